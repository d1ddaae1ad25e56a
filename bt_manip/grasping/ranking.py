"""Rank grasp candidates by cost."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .grasp_candidate import GraspCandidate, GraspTable
from .hand import Hand

COST_TOLERANCE = 0.03
"""Difference of costs below which two grasps are equally good: the arm takes the nearer one."""

_TRANSLATION_WEIGHT = 10.0  # [rad/m] of the tool's distance beside the approach axis
_COST_WEIGHT = 0.3  # [rad] per cost where grasps are ranked by distance
_MAX_LEVER = 0.05  # [m] of the centre of mass at which balance costs its whole weight
_MIN_SLACK = 5e-3  # [m] opening beside the object, on each side, below which slack costs


class GraspCost(NamedTuple):
    """Cost of a grasp by criterion, each from 0 to its weight."""

    tilt: float
    """Angle between the approach direction and straight down."""
    balance: float
    """Horizontal distance of the centre of mass from the fingers."""
    contact: float
    """Fraction of the pads that is not in contact."""
    angle: float
    """Angle between the closing direction and the surface normals."""
    slack: float
    """How little wider than the object the fingers open."""
    depth: float
    """How far the tool is kept short of the preferred depth."""

    @property
    def total(self) -> float:
        """Sum over the criteria."""
        return sum(self)

    def __str__(self) -> str:
        """Return the total and the criteria that contribute, largest first."""
        parts = sorted(self._asdict().items(), key=lambda item: -item[1])
        named = ", ".join(f"{name} {cost:.2f}" for name, cost in parts if cost >= 0.005)
        return f"{self.total:.2f} ({named})" if named else "0"


WEIGHTS = GraspCost(tilt=1.0, balance=0.5, contact=0.3, angle=1.0, slack=0.3, depth=0.5)
"""Largest cost of each criterion."""


class RankedGrasp(NamedTuple):
    """A grasp candidate in the world, with its cost."""

    grasp: GraspCandidate
    T_wt: pin.SE3
    cost: GraspCost
    tool_distance: float
    """Rotation and weighted sideways translation of the tool to its approach axis [rad]."""


class GraspRanking:
    """The grasp candidates of one object in its present pose, compared without moving the arm."""

    def __init__(
        self, grasps: GraspTable, T_wo: pin.SE3, com: np.ndarray, hand: Hand, T_now: pin.SE3
    ) -> None:
        """Compute the cost of each candidate.

        Args:
            grasps: Grasp candidates of the object.
            T_wo: Pose of the object.
            com: Its centre of mass, in its frame [m].  # (3,)
            hand: The gripper.
            T_now: Present pose of the tool.
        """
        self._grasps, self._T_wo = grasps, T_wo
        R = T_wo.rotation @ grasps.rotation
        position = grasps.position @ T_wo.rotation.T + T_wo.translation
        lever = np.linalg.norm((T_wo.act(com) - position)[:, :2], axis=1)
        shares = dict(
            tilt=np.arccos(np.clip(-R[:, 2, 2], -1.0, 1.0)) / (0.5 * math.pi),
            balance=lever / _MAX_LEVER,
            contact=1.0 - grasps.contact,
            angle=grasps.normal_angle / (0.25 * math.pi),
            slack=1.0 - 0.5 * (hand.stroke - grasps.width) / _MIN_SLACK,
            depth=grasps.depth_loss / max(hand.tip + hand.palm, 1e-3),
        )
        self._costs = (
            np.clip(np.stack([shares[name] for name in GraspCost._fields], axis=1), 0.0, 1.0)
            * WEIGHTS
        )
        self._total = self._costs.sum(axis=1)
        cosine = 0.5 * (np.einsum("nij,ij->n", R, T_now.rotation) - 1.0)
        self._rotation = np.arccos(np.clip(cosine, -1.0, 1.0))
        offset, approach = T_now.translation - position, R[:, :, 2]
        on_axis = np.einsum("ij,ij->i", offset, approach)[:, None] * approach
        sideways = np.linalg.norm(offset - on_axis, axis=1)
        self._tool_distance = self._rotation + _TRANSLATION_WEIGHT * sideways

    def by_cost(self) -> Iterator[RankedGrasp]:
        """Iterate by cost; equally good grasps by the rotation of the tool."""
        order = np.argsort(self._total, kind="stable")
        sorted_total = self._total[order]
        first = 0
        while first < len(order):
            last = int(np.searchsorted(sorted_total, sorted_total[first] + COST_TOLERANCE))
            tier = order[first : max(last, first + 1)]
            for i in tier[np.argsort(self._rotation[tier], kind="stable")]:
                yield self._ranked(int(i))
            first += len(tier)

    def by_distance(self) -> Iterator[RankedGrasp]:
        """Iterate by the distance of the tool to the approach axis, with a small cost term."""
        for i in np.argsort(self._tool_distance + _COST_WEIGHT * self._total, kind="stable"):
            yield self._ranked(int(i))

    def _ranked(self, i: int) -> RankedGrasp:
        grasp = self._grasps[i]
        cost = GraspCost(*self._costs[i].tolist())
        return RankedGrasp(grasp, self._T_wo * grasp.T_ot, cost, float(self._tool_distance[i]))
