"""Plan the approach to a grasp and the lift after it."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.arm import MARGIN, Arm
from bt_manip.cell import entity_of
from bt_manip.exceptions import MotionError
from bt_manip.planning import plan_straight_approach, translate_along_tool_z

from .grasp_candidate import GraspCandidate
from .gripper_clearance import GripperClearance
from .ranking import RankedGrasp
from .rejections import Rejections

MAX_APPROACHES = 24
"""Largest number of infeasible straight approaches before the search ends."""

MAX_SIDE_STANDOFF = 0.12
"""Largest distance of the pre-grasp pose from a grasp that is not approached from above [m]."""

LIFT_HEIGHT = 0.05
"""Height through which the object must be free to be lifted [m]."""

_SEARCHES = ((0, MARGIN), (1, MARGIN), (8, MARGIN), (8, 0.0))
"""Random restarts and joint limit margin [rad] of each IK search: usually the first succeeds."""

_FROM_ABOVE = math.cos(math.radians(30.0))
_MAX_LIFT_PENETRATION = 1e-3  # [m] of the lifted object in what it touches


class GraspPlan(NamedTuple):
    """A feasible grasp, with the configuration from which it is approached."""

    grasp: GraspCandidate
    T_wt: pin.SE3
    """Pose of the tool at the grasp."""
    q_pregrasp: np.ndarray
    """Configuration at the pre-grasp pose, a straight line along the tool's axis away."""  # (nq,)
    standoff: float
    """Distance from the pre-grasp pose to the grasp [m]."""
    reason: str
    """Cost of the grasp, distance to it, and how many were rejected before it."""


class ApproachPlanner:
    """Plans collision-free approaches to the grasps of one object, in the present situation."""

    def __init__(
        self, arm: Arm, name: str, clearance: GripperClearance, rejections: Rejections
    ) -> None:
        """Plan for an arm.

        Args:
            arm: The arm.
            name: The object.
            clearance: Measures the gripper's clearance at the object.
            rejections: Counts the grasps that are not feasible.
        """
        self._arm, self._name = arm, name
        self._clearance, self._rejections = clearance, rejections

    def plan(
        self, batch: Sequence[RankedGrasp], height: float, centre: np.ndarray
    ) -> GraspPlan | None:
        """Return the plan whose pre-grasp configuration is nearest, for one of several grasps.

        Args:
            batch: Equally good grasps.
            height: Height of the pre-grasp pose over the object's centre, along its axis [m].
            centre: The object's centre in the world [m].  # (3,)

        Returns:
            The plan, or None when no grasp of the batch is feasible.

        Raises:
            MotionError: When the arm reaches a grasp but not its pre-grasp pose.
        """
        arm, rejections = self._arm, self._rejections
        standoffs = [_standoff(one.T_wt, height, centre) for one in batch]
        poses = [
            translate_along_tool_z(one.T_wt, -s) for one, s in zip(batch, standoffs, strict=True)
        ]
        if arm.world is not None:
            arm.world.refresh()
        best: tuple[float, GraspPlan] | None = None
        solved = False
        for starts, margin in _SEARCHES:
            if best is not None:
                break
            for found in arm.ik.solutions(poses, arm.q, restarts=starts, margin=margin):
                solved = True
                if rejections.approaches >= MAX_APPROACHES:
                    break
                planned = self._plan_from(batch[found.target], found.q, standoffs[found.target])
                if planned is not None and planned[0] >= MARGIN:
                    return planned[1]
                if planned is not None and (best is None or planned[0] > best[0]):
                    best = planned
        if best is not None:
            return best[1]
        if not solved:
            self._check_pregrasp(batch, height)
            rejections.unreachable(len(batch))
        return None

    def _plan_from(
        self, one: RankedGrasp, q: np.ndarray, standoff: float
    ) -> tuple[float, GraspPlan] | None:
        """Return the approach from a configuration, with its joint limit margin [rad]."""
        arm, rejections = self._arm, self._rejections
        collisions = arm.world.collisions(q) if arm.world is not None else []
        if collisions:
            rejections.collision(entity_of(collisions[0].second))
            return None
        margin, end, error = plan_straight_approach(arm.ik, q, one.T_wt, arm.world)
        if margin <= 0.0:
            rejections.no_approach(error)
            return None
        if not self._can_lift(one, end):
            return None
        reason = (
            f"{_describe(one)}; joint limit margin {margin:.2f} rad, "
            f"{arm.ik.distance(q, arm.q):.2f} s away"
        )
        if rejections.total:
            reason += f"; {rejections.total} rejected before"
        return margin, GraspPlan(one.grasp, one.T_wt, q, standoff, reason)

    def _check_pregrasp(self, batch: Sequence[RankedGrasp], height: float) -> None:
        """Raise a `MotionError` when only the pre-grasp poses are unreachable."""
        arm, name = self._arm, self._name
        above = height > 0.0 and all(_from_above(one.T_wt) for one in batch)
        if above and arm.ik.nearest([one.T_wt for one in batch], arm.q).solved:
            raise MotionError(
                f"{height:g} m over '{name}' is unreachable, though '{name}' is not",
                reason="unreachable",
            )

    def _can_lift(self, one: RankedGrasp, q: np.ndarray) -> bool:
        """Return whether gripper and object can move straight up from the grasp."""
        clearance, rejections = self._clearance, self._rejections
        steps = [np.array([0.0, 0.0, part * LIFT_HEIGHT]) for part in (0.5, 1.0)]
        lifted = clearance.of_displaced(self._name, steps)
        if lifted.distance < -_MAX_LIFT_PENETRATION:
            rejections.collision(lifted.entity)
            return False
        if _from_above(one.T_wt):
            return True  # nearly the approach, reversed
        T = one.T_wt
        poses = [pin.SE3(T.rotation, T.translation + step) for step in steps]
        for pose in poses:
            found = clearance.at_pose(pose)
            if found.distance < 0.0:
                rejections.collision(found.entity)
                return False
        error = plan_straight_approach(self._arm.ik, q, poses[-1], None).error
        if error is not None:
            rejections.no_approach(error)
            return False
        return True


def _standoff(T_wt: pin.SE3, height: float, centre: np.ndarray) -> float:
    """Return the distance from the pre-grasp pose to the grasp [m]."""
    a = T_wt.rotation[:, 2]
    standoff = max(height + float(a @ (T_wt.translation - centre)), 0.0)
    return standoff if _from_above(T_wt) else min(standoff, MAX_SIDE_STANDOFF)


def _from_above(T_wt: pin.SE3) -> bool:
    return bool(-T_wt.rotation[2, 2] > _FROM_ABOVE)


def _describe(one: RankedGrasp) -> str:
    """Return approach direction, width and cost of a grasp as text."""
    tilt = math.degrees(math.acos(float(np.clip(-one.T_wt.rotation[2, 2], -1.0, 1.0))))
    approach = "from above" if tilt < 5.0 else f"{tilt:.0f} degrees from vertical"
    return f"{approach}, {1e3 * one.grasp.width:.0f} mm wide; cost {one.cost}"
