"""Search for a feasible grasp of one object."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.arm import MARGIN, Arm
from bt_manip.cell import entity_of
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import DISTINCT, PoseTarget
from bt_manip.planning import plan_straight_approach, translate_along_tool_z
from bt_manip.robots import GraspCandidate
from bt_manip.trajectories import SplinePath

from .gripper_clearance import MAX_PENETRATION, SUFFICIENT_CLEARANCE, GripperClearance
from .ranking import COST_TOLERANCE, GraspRanking, RankedGrasp
from .rejections import Rejections

MAX_SIDE_STANDOFF = 0.12
"""Largest distance between grasp and pre-grasp pose, unless the approach is from above [m]."""

LIFT_CLEARANCE = 0.05
"""Height of the checked lift [m]."""

MAX_CLEARANCE_CHECKS = 128  # maximum number of grasps whose clearance is measured
MAX_APPROACHES = 24  # maximum number of infeasible straight approaches
MAX_BATCHES = 6
BATCH_SIZE = 4  # equally good grasps that are solved together

_SEARCHES = ((0, MARGIN), (1, MARGIN), (8, MARGIN), (8, 0.0))
"""Random restarts and joint limit margin [rad] of successive IK searches."""


_FROM_ABOVE = math.cos(math.radians(30.0))
_AT_PREGRASP = 0.05  # [rad] tool distance up to which the tool is at the pre-grasp pose
_CLOSING_STEP = 0.3  # [openings] between checks: 24 mm of the Panda's 80
_MAX_CLOSING_PENETRATION = 0.5e-3  # [m]
_MAX_LIFT_PENETRATION = 1e-3  # [m] of the lifted object in touched entities


class GraspPlan(NamedTuple):
    """A feasible grasp with its pre-grasp configuration."""

    grasp: GraspCandidate
    T_wt: pin.SE3
    """Pose of the tool at the grasp."""
    q_pregrasp: np.ndarray
    """Configuration at the pre-grasp pose, at the start of the straight approach."""  # (nq,)
    reason: str
    """Cost of the grasp, distance to it, and number of grasps rejected before, as text."""
    approach: SplinePath | None = None
    """Joint path along this line, if it was computed already."""


@dataclass
class CheckedGrasps:
    """The grasps checked by a search, for viewers.

    Attributes:
        object: Name of the object.
        closing: Closing direction, see `GraspCandidates`.
        grasps: The grasps in the order of their checks, with whether the gripper has clearance.
        chosen: The chosen grasp; None if none is feasible.
    """

    object: str
    closing: np.ndarray | None
    grasps: list[tuple[GraspCandidate, bool]] = field(default_factory=list)
    chosen: GraspCandidate | None = None


class GraspSearch:
    """Searches for a feasible grasp of one object in the present state of the cell.

    Args:
        arm: The arm.
        name: The object.
        ranking: Its ranked grasp candidates.
        clearance: Measures the gripper's clearance at the object.

    Attributes:
        checked: The grasps checked so far.
        rejections: Counts of rejected grasps by reason.
    """

    def __init__(
        self,
        arm: Arm,
        name: str,
        ranking: GraspRanking,
        clearance: GripperClearance,
        rejections: Rejections,
    ) -> None:
        self._arm, self._name, self._ranking = arm, name, ranking
        self._clearance, self.rejections = clearance, rejections
        self.checked = CheckedGrasps(name, ranking.candidates.closing)
        self._reached: dict[tuple[float, ...], bool] = {}  # at any turn, by height and axis

    def nearest(self) -> RankedGrasp | None:
        """Return the grasp with clearance whose approach axis is nearest to the tool."""
        found = next(self._with_clearance(self._ranking.by_distance()), None)
        self.checked.chosen = found and found.grasp
        return found

    def best(self, heights: Sequence[float], centre: np.ndarray) -> GraspPlan | None:
        """Return the plan of the feasible grasp of lowest cost.

        Args:
            heights: Heights of the pre-grasp pose over the object's centre along its axis, in the
                order of trials [m].
            centre: The object's centre in the world [m].  # (3,)

        Raises:
            MotionError: If the arm reaches a grasp but none of its pre-grasp poses.
        """
        grasps, left = self._with_clearance(self._ranking.by_cost()), list(heights)
        for batch in islice(_batches(grasps), MAX_BATCHES):
            if self.rejections.approaches >= MAX_APPROACHES:
                break
            plan = self._plan_from_first(batch, left, centre)
            if plan is not None:
                self.checked.chosen = plan.grasp
                return plan
        return None

    def _plan_from_first(
        self, batch: Sequence[RankedGrasp], heights: list[float], centre: np.ndarray
    ) -> GraspPlan | None:
        """Return the plan at the first reachable height; drop the unreachable ones before it."""
        while True:
            try:
                return self._plan(batch, heights[0], centre)
            except MotionError:
                if len(heights) == 1:
                    raise
                del heights[0]

    def _with_clearance(self, ranked: Iterable[RankedGrasp]) -> Iterator[RankedGrasp]:
        """Yield the grasps with sufficient clearance in their order, then those with less.

        A grasp with less is not postponed if the tool is already at its pre-grasp pose.
        """
        tight = []
        for candidate in islice(ranked, MAX_CLEARANCE_CHECKS):
            found = self._clearance.at_pose(candidate.T_wt)
            clear = found.distance >= -MAX_PENETRATION
            if not clear:
                self.rejections.no_clearance[found.entity] += 1
            elif not (clear := self._can_close(candidate)):
                self.rejections.self_obstructed += 1
            self.checked.grasps.append((candidate.grasp, clear))
            if not clear:
                continue
            if found.distance < SUFFICIENT_CLEARANCE and candidate.tool_distance > _AT_PREGRASP:
                tight.append(candidate)
            else:
                yield candidate
        yield from tight

    def _can_close(self, candidate: RankedGrasp) -> bool:
        """Return whether the gripper reaches the contacts before it touches another part."""
        clearance, name = self._clearance, self._name
        if self._ranking.candidates.clear:
            return True
        if clearance.to_entity(name, candidate.T_wt) < 0.0:
            return False
        steps = max(1, math.ceil((1.0 - candidate.opening) / _CLOSING_STEP))
        try:
            for k in range(1, steps + 1):
                clearance.open(1.0 + (candidate.opening - 1.0) * k / steps)
                if clearance.to_entity(name, candidate.T_wt) < -_MAX_CLOSING_PENETRATION:
                    return False
        finally:
            clearance.open()
        return True

    def _plan(
        self, batch: Sequence[RankedGrasp], height: float, centre: np.ndarray
    ) -> GraspPlan | None:
        """Return the plan with the nearest pre-grasp configuration, of equally good grasps.

        Grasps with a free axis are first solved at any turn, once for all grasps that differ by it.
        """
        if self._arm.world is not None:
            self._arm.world.refresh()
        reached = self._reached
        free = {
            key: candidate
            for candidate in batch
            if (key := _turns(candidate, height)) and key not in reached
        }
        reached.update(dict.fromkeys(free, False))
        plan, solved = self._nearest(list(free.values()), height, centre)
        reached.update((key, True) for i, key in enumerate(free) if i in solved)
        if plan is not None:
            return plan
        fixed = [
            candidate._replace(free_axis=None)
            for candidate in batch
            if reached.get(_turns(candidate, height), True)
        ]
        plan, solved = self._nearest(fixed, height, centre)
        if plan is None and not solved:
            self._check_pregrasp(batch, height)
            self.rejections.unreachable += len(batch)
        return plan

    def _nearest(
        self, grasps: Sequence[RankedGrasp], height: float, centre: np.ndarray
    ) -> tuple[GraspPlan | None, set[int]]:
        """Return the plan nearest to the arm, and the indices of the reachable grasps."""
        arm, rejections = self._arm, self.rejections
        standoffs = [standoff_of(candidate.T_wt, height, centre) for candidate in grasps]
        targets = [self._target(*pair) for pair in zip(grasps, standoffs, strict=True)]
        best: tuple[float, GraspPlan] | None = None
        tried: list[np.ndarray] = []
        reached: set[int] = set()
        for restarts, margin in _SEARCHES if grasps else ():
            if best is not None:
                break
            for found in arm.ik.nearest_first(targets, arm.q, restarts=restarts, margin=margin):
                reached.add(found.target)
                if rejections.approaches >= MAX_APPROACHES:
                    break
                if any(np.abs(found.q - q).max() <= DISTINCT for q in tried):
                    continue
                tried.append(found.q)
                planned = self._plan_from(grasps[found.target], found.q, standoffs[found.target])
                if planned is not None and planned[0] >= MARGIN:
                    return planned[1], reached
                if planned is not None and (best is None or planned[0] > best[0]):
                    best = planned
        return best and best[1], reached

    def _plan_from(
        self, candidate: RankedGrasp, q: np.ndarray, standoff: float
    ) -> tuple[float, GraspPlan] | None:
        """Return the plan from a configuration, with its joint limit margin [rad]."""
        arm, rejections = self._arm, self.rejections
        if candidate.free_axis is not None:
            candidate = candidate.turned(translate_along_tool_z(arm.ik.model.pose(q), standoff))
            tight = self._clearance.at_pose(candidate.T_wt).distance < SUFFICIENT_CLEARANCE
            if tight or not self._can_close(candidate):
                return None
        collisions = arm.world.collisions(q) if arm.world is not None else []
        if collisions:
            rejections.collisions[collisions[0][:2]] += 1
            return None
        approach = plan_straight_approach(arm.ik, q, candidate.T_wt, arm.world)
        margin = approach.limit_margin
        if margin <= 0.0:
            rejections.reject_approach(approach.error)
            return None
        if not self._can_lift(candidate, approach.end):
            return None
        reason = (
            f"{candidate.describe()}; {margin:.2f} rad from the nearest joint limit; "
            f"{arm.ik.distance(q, arm.q):.2f} s away at full joint speed"
        )
        if rejections.total:
            reason += f"; {rejections.total} grasps rejected before"
        return margin, GraspPlan(candidate.grasp, candidate.T_wt, q, reason, approach.curve)

    def _target(self, candidate: RankedGrasp, standoff: float = 0.0) -> pin.SE3 | PoseTarget:
        """Return the tool's target at a distance before a grasp [m], with its free axis if any."""
        T_wt = translate_along_tool_z(candidate.T_wt, -standoff)
        if candidate.free_axis is None or candidate.pivot is None:
            return T_wt
        pivot = candidate.pivot + [0.0, 0.0, standoff]
        return PoseTarget(self._arm.ik.tool, T_wt, free_axis=candidate.free_axis, pivot=pivot)

    def _check_pregrasp(self, batch: Sequence[RankedGrasp], height: float) -> None:
        """Raise a `MotionError` if only the pre-grasp poses are unreachable."""
        arm, name = self._arm, self._name
        above = height > 0.0 and all(_from_above(candidate.T_wt) for candidate in batch)
        targets = {
            _turns(candidate) or (i,): self._target(candidate) for i, candidate in enumerate(batch)
        }
        if above and arm.ik.nearest(list(targets.values()), arm.q).solved:
            raise MotionError(
                f"{height:g} m over '{name}' is unreachable, though '{name}' is not",
                reason="unreachable",
            )

    def _can_lift(self, candidate: RankedGrasp, q: np.ndarray) -> bool:
        """Return whether gripper and object can move straight up from the grasp."""
        clearance, rejections = self._clearance, self.rejections
        steps = [np.array([0.0, 0.0, part * LIFT_CLEARANCE]) for part in (0.5, 1.0)]
        lifted = clearance.of_displaced(self._name, steps)
        if lifted.distance < -_MAX_LIFT_PENETRATION:
            rejections.collisions[self._name, lifted.entity] += 1
            return False
        if _from_above(candidate.T_wt):
            return True  # nearly the reversed approach
        T = candidate.T_wt
        poses = [pin.SE3(T.rotation, T.translation + step) for step in steps]
        for pose in poses:
            found = clearance.at_pose(pose)
            if found.distance < 0.0:
                rejections.collisions["gripper", found.entity] += 1
                return False
        world, lift = self._arm.world, plan_straight_approach(self._arm.ik, q, poses[-1], None)
        if lift.error is not None:
            rejections.reject_approach(lift.error)
            return False
        for first, second, _ in world.collisions(lift.end) if world is not None else ():
            if self._name not in (entity_of(first), entity_of(second)):
                rejections.collisions[first, second] += 1
                return False
        return True


def _turns(candidate: RankedGrasp, *height: float) -> tuple[float, ...]:
    """Return a key that is equal for grasps that differ by a turn about their free axis.

    Empty without a free axis.
    """
    if candidate.free_axis is None or candidate.pivot is None:
        return ()
    return (*height, *(np.round([*candidate.free_axis, *candidate.pivot], 6) + 0.0).tolist())


def _batches(grasps: Iterable[RankedGrasp]) -> Iterator[list[RankedGrasp]]:
    """Group consecutive grasps that are equally good."""
    batch: list[RankedGrasp] = []
    for candidate in grasps:
        if batch and abs(candidate.cost - batch[0].cost) >= COST_TOLERANCE:
            yield batch
            batch = []
        batch.append(candidate)
        if len(batch) == BATCH_SIZE:
            yield batch
            batch = []
    if batch:
        yield batch


def standoff_of(T_wt: pin.SE3, height: float, centre: np.ndarray) -> float:
    """Return the distance from the pre-grasp pose to the grasp [m]."""
    a = T_wt.rotation[:, 2]
    standoff = max(height + float(a @ (T_wt.translation - centre)), 0.0)
    return standoff if _from_above(T_wt) else min(standoff, MAX_SIDE_STANDOFF)


def _from_above(T_wt: pin.SE3) -> bool:
    return bool(-T_wt.rotation[2, 2] > _FROM_ABOVE)
