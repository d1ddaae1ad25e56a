"""Ranking of grasp candidates by cost."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.robots import GraspCandidate, GraspCandidates

COST_TOLERANCE = 0.03
"""Difference of costs below which grasps are equally good, so that the nearest one is chosen."""

TILT_WEIGHT = 1.0
"""Cost of an approach from the side; it decreases with the angle to straight down."""

BALANCE_WEIGHT = 0.5
"""Cost of a grasp with the centre of mass `_MAX_LEVER` or more beside the tool."""

_MAX_LEVER = 0.05  # [m]
_PARALLEL = 1.0 - 1e-6  # minimum cosine between parallel axes
_TRANSLATION_WEIGHT = 10.0  # [rad/m] weight of the tool's distance from the approach axis
_COST_WEIGHT = 0.3  # [rad] weight of the cost in a ranking by distance


class RankedGrasp(NamedTuple):
    """A grasp candidate in the world, with its cost."""

    grasp: GraspCandidate
    T_wt: pin.SE3
    """Pose of the tool at the grasp."""
    opening: float
    """Opening of the gripper just before contact."""
    costs: Mapping[str, float]
    """Cost by criterion."""
    cost: float
    """Sum of the costs."""
    tool_distance: float
    """Distance of the tool to the approach axis: rotation and weighted translation [rad]."""
    free_axis: np.ndarray | None = None
    """Unit axis in the tool's frame about which turns do not change the cost."""  # (3,)
    pivot: np.ndarray | None = None
    """A point of the free axis in the tool's frame [m]."""  # (3,)

    def turned(self, T_wt: pin.SE3) -> "RankedGrasp":
        """Return the grasp turned about its free axis to another pose of the tool."""
        T_ot = self.grasp.T_ot * self.T_wt.actInv(T_wt)
        return self._replace(grasp=replace(self.grasp, T_ot=T_ot), T_wt=T_wt)

    def describe(self) -> str:
        """Return approach direction, width and costs as text, the largest cost first."""
        tilt = math.degrees(math.acos(float(np.clip(-self.T_wt.rotation[2, 2], -1.0, 1.0))))
        approach = "from above" if tilt < 5.0 else f"{tilt:.0f} degrees from vertical"
        parts = sorted(self.costs.items(), key=lambda item: -item[1])
        named = ", ".join(f"{name} {cost:.2f}" for name, cost in parts if cost >= 0.005)
        cost = f"; cost {self.cost:.2f} ({named})" if named else ""
        return f"{approach}, {1e3 * self.grasp.width:.0f} mm wide{cost}"


class GraspRanking:
    """The grasp candidates of one object at its present pose, ranked by geometry.

    Args:
        T_wo: Pose of the object.
        com: The object's centre of mass, in its frame [m].  # (3,)
        T_now: Present pose of the tool.

    Attributes:
        candidates: The grasp candidates.
    """

    def __init__(
        self, candidates: GraspCandidates, T_wo: pin.SE3, com: np.ndarray, T_now: pin.SE3
    ) -> None:
        self.candidates, self._T_wo = candidates, T_wo
        R = T_wo.rotation @ candidates.rotation
        position = candidates.position @ T_wo.rotation.T + T_wo.translation
        lever = np.linalg.norm((T_wo.act(com) - position)[:, :2], axis=1)
        tilt = np.arccos(np.clip(-R[:, 2, 2], -1.0, 1.0)) / (0.5 * math.pi)
        self._costs = {
            "tilt": TILT_WEIGHT * np.clip(tilt, 0.0, 1.0),
            "balance": BALANCE_WEIGHT * np.clip(lever / _MAX_LEVER, 0.0, 1.0),
            **candidates.costs,
        }
        self._total = np.stack(list(self._costs.values()), axis=1).sum(axis=1)
        self._rotation = _angle(R, T_now.rotation)
        self._turnable = np.zeros(len(candidates), dtype=bool)
        if candidates.free_axis is not None and candidates.pivot is not None:
            # Turns about the vertical or the approach axis do not change tilt and balance.
            axis = candidates.free_axis @ T_wo.rotation.T
            along = np.maximum(abs(axis[:, 2]), abs(np.einsum("ij,ij->i", axis, R[:, :, 2])))
            k = self._turnable = along > _PARALLEL
            pivot = candidates.pivot @ T_wo.rotation.T + T_wo.translation
            turn = _turn_towards(T_now.rotation, R[k], axis[k])
            R[k] = turn @ R[k]
            position[k] = pivot[k] + np.einsum("nij,nj->ni", turn, position[k] - pivot[k])
        self._nearest = R, position
        offset, approach = T_now.translation - position, R[:, :, 2]
        on_axis = np.einsum("ij,ij->i", offset, approach)[:, None] * approach
        sideways = np.linalg.norm(offset - on_axis, axis=1)
        self._tool_distance = _angle(R, T_now.rotation) + _TRANSLATION_WEIGHT * sideways

    def by_cost(self) -> Iterator[RankedGrasp]:
        """Yield grasps by cost; equally good grasps by the rotation of the tool."""
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
        """Yield grasps by the distance of the tool to the approach axis, plus a small cost term.

        Grasps with a free axis are turned to the rotation nearest to the tool's.
        """
        R, position = self._nearest
        for i in np.argsort(self._tool_distance + _COST_WEIGHT * self._total, kind="stable"):
            grasp = self._ranked(int(i))
            yield grasp.turned(pin.SE3(R[i], position[i])) if self._turnable[i] else grasp

    def _ranked(self, i: int) -> RankedGrasp:
        grasp, candidates = self.candidates[i], self.candidates
        T_wt = self._T_wo * grasp.T_ot
        free_axis = pivot = None
        if self._turnable[i]:
            assert candidates.free_axis is not None and candidates.pivot is not None
            free_axis = grasp.T_ot.rotation.T @ candidates.free_axis[i]
            pivot = grasp.T_ot.actInv(np.array(candidates.pivot[i]))
        return RankedGrasp(
            grasp,
            T_wt,
            float(self.candidates.opening[i]),
            {name: float(column[i]) for name, column in self._costs.items()},
            float(self._total[i]),
            float(self._tool_distance[i]),
            free_axis,
            pivot,
        )


def _angle(R: np.ndarray, R_now: np.ndarray) -> np.ndarray:
    """Return the angles between rotations and a given one [rad]."""  # (n,)
    cosine = 0.5 * (np.einsum("nij,ij->n", R, R_now) - 1.0)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


def _turn_towards(R_now: np.ndarray, R: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return the turns about an axis for each rotation that bring it nearest to a given one.

    They maximize the trace of R_now^T turn R, which is a sinusoid of the angle.
    """  # (n, 3, 3)
    M = R @ R_now.T
    skew, along = -np.cross(axis[:, None], np.eye(3)), axis[:, :, None] * axis[:, None]
    sine = np.einsum("nij,nji->n", skew, M)
    cosine = np.einsum("nij,nji->n", np.eye(3) - along, M)
    angle = np.arctan2(sine, cosine)[:, None, None]
    return np.asarray(along + np.sin(angle) * skew + np.cos(angle) * (np.eye(3) - along))
