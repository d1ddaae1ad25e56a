"""Rank grasp candidates by cost."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.robots import GraspCandidate, GraspCandidates

COST_TOLERANCE = 0.03
"""Difference of costs below which two grasps are equally good: the arm takes the nearer one."""

TILT_WEIGHT = 1.0
"""Cost of an approach from the side; it falls with the angle to straight down."""

BALANCE_WEIGHT = 0.5
"""Cost of a grasp whose centre of mass is `_MAX_LEVER` beside the tool, or more."""

_MAX_LEVER = 0.05  # [m]
_PARALLEL = 1.0 - 1e-6  # cosine from which on two axes are parallel
_TRANSLATION_WEIGHT = 10.0  # [rad/m] of the tool's distance beside the approach axis
_COST_WEIGHT = 0.3  # [rad] per cost where grasps are ranked by distance


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
    """Rotation and weighted sideways translation of the tool to its approach axis [rad]."""
    free_axis: np.ndarray | None = None
    """Unit axis in the tool's frame about which it may be turned at the same cost."""  # (3,)
    pivot: np.ndarray | None = None
    """A point of that axis in the tool's frame [m]."""  # (3,)

    def describe(self) -> str:
        """Return approach direction, width and costs as text, the largest cost first."""
        tilt = math.degrees(math.acos(float(np.clip(-self.T_wt.rotation[2, 2], -1.0, 1.0))))
        approach = "from above" if tilt < 5.0 else f"{tilt:.0f} degrees from vertical"
        parts = sorted(self.costs.items(), key=lambda item: -item[1])
        named = ", ".join(f"{name} {cost:.2f}" for name, cost in parts if cost >= 0.005)
        cost = f"; cost {self.cost:.2f} ({named})" if named else ""
        return f"{approach}, {1e3 * self.grasp.width:.0f} mm wide{cost}"


class GraspRanking:
    """The grasp candidates of one object in its present pose, compared without moving the arm.

    Attributes:
        candidates: The grasp candidates.
    """

    def __init__(
        self, candidates: GraspCandidates, T_wo: pin.SE3, com: np.ndarray, T_now: pin.SE3
    ) -> None:
        """Compute the cost of each candidate.

        Args:
            candidates: Grasp candidates of the object.
            T_wo: Pose of the object.
            com: Its centre of mass, in its frame [m].  # (3,)
            T_now: Present pose of the tool.
        """
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
        grasp, candidates = self.candidates[i], self.candidates
        T_wt = self._T_wo * grasp.T_ot
        free_axis = pivot = None
        if candidates.free_axis is not None and candidates.pivot is not None:
            axis = self._T_wo.rotation @ candidates.free_axis[i]
            # Turned about the vertical or the approach axis, it is tilted and balanced the same.
            if max(abs(axis[2]), abs(axis @ T_wt.rotation[:, 2])) > _PARALLEL:
                free_axis = T_wt.rotation.T @ axis
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
