"""Several arms in one cell, each out of the way of the others."""

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from bt_manip.collision import (
    INTER_ROBOT_CLEARANCE,
    INTER_ROBOT_STEP,
    InterRobotDistance,
    OtherRobot,
    RobotGeometry,
)
from bt_manip.exceptions import MotionError
from bt_manip.trajectories import JointTrajectory, MotionProfile, SequenceTrajectory, Trajectory

if TYPE_CHECKING:
    from .moving_arm import MovingArm

DELAY = 0.1
"""By whole times of this a motion starts later where another arm has to pass first [s]."""

_SLACK = 1e-4  # [m]


class MultiArmCoordinator:
    """Keeps arms from meeting, as long as each follows its reference.

    What every arm will do is known: it goes on along its trajectory, and then rests. At any moment
    these ways are free of each other, and stay so:

    - A new motion is planned around where the others will come to rest, by the arm's own
      `CollisionWorld`, and is compared with their motions moment by moment. Where it would come too
      near to one of them it starts later, at the latest when that one rests.
    - Where an arm leaves its way in time unplanned, because it is stopped or its pace is changed,
      all others are looked at again, and those that would come too near to it are stopped too; it
      is stopped itself where one that rests is in its way by now.
    """

    def __init__(self, arms: Mapping[str, "MovingArm"]) -> None:
        """Let arms know of each other.

        Args:
            arms: The arms of one cell by the names of their robots; each has a world.
        """
        self._arms = dict(arms)
        figures = {name: RobotGeometry(arm.robot, arm.model) for name, arm in arms.items()}
        self._encounters = {
            (a, b): InterRobotDistance(figures[a], figures[b]) for a, b in combinations(arms, 2)
        }
        for name, arm in arms.items():
            assert arm.world is not None
            arm.traffic = self
            arm.world.others = tuple(
                OtherRobot(other, figures[other], arms[other]) for other in arms if other != name
            )

    def yield_to_others(self, arm: "MovingArm", trajectory: Trajectory) -> Trajectory:
        """Let a motion start so late that it does not come too near to another arm's.

        Args:
            arm: Whose motion it is.
            trajectory: What it would follow from now on.

        Raises:
            MotionError: When another one is in the way at any start.
        """
        others = {name: other for name, other in self._others(arm) if other.moving}
        if not others or arm.speed_scale == 0.0:
            return trajectory
        latest = max(other.remaining for other in others.values())
        blocker = ""
        for delay in (*np.arange(0.0, latest, DELAY), latest):
            later = _delayed(arm, trajectory, float(delay))
            if later is None:
                break
            since = 0.0 if arm.moving else float(delay)  # resting, the others have planned for
            found = (n for n in others if self._meets(arm, later, n, since))
            blocker = next(found, "")
            if not blocker:
                return later
        raise MotionError(f"'{blocker}' is in the way of the motion", reason="robot")

    def changed(self, arm: "MovingArm") -> None:
        """Look at all ways again, after an arm has left its own in time unplanned."""
        name = self._name(arm)
        for other_name, other in self._others(arm):
            if _goes_on(other):
                who, cause = other, f"'{name}' is in the way: it goes on otherwise than planned"
            else:
                who, cause = arm, f"'{other_name}' is in the way by now"
            if _goes_on(who) and self._will_meet(name, other_name):
                who.give_up(cause)

    def _name(self, arm: "MovingArm") -> str:
        return next(name for name, known in self._arms.items() if known is arm)

    def _others(self, arm: "MovingArm") -> Iterator[tuple[str, "MovingArm"]]:
        return ((name, other) for name, other in self._arms.items() if other is not arm)

    def _meets(self, arm: "MovingArm", trajectory: Trajectory, other: str, since: float) -> bool:
        """Tell whether a new motion comes too near to another arm while that one moves."""
        until = self._arms[other].remaining
        times = np.arange(since, until, INTER_ROBOT_STEP)
        if not len(times):
            return False
        ahead = trajectory.sample(np.minimum(arm.speed_scale * times, trajectory.duration))[0]
        encounter, rows = self._pair(self._name(arm), other, ahead, self._arms[other].ahead(times))
        return encounter.meet(*rows, INTER_ROBOT_CLEARANCE)

    def _will_meet(self, first: str, second: str) -> bool:
        """Tell whether two arms come too near to each other, or nearer than they are."""
        arms = self._arms[first], self._arms[second]
        times = np.arange(
            0.0, max(arm.remaining for arm in arms) + INTER_ROBOT_STEP, INTER_ROBOT_STEP
        )
        encounter, rows = self._pair(first, second, *(arm.ahead(times) for arm in arms))
        now = encounter.distance(rows[0][0], rows[1][0])
        return encounter.meet(*rows, min(INTER_ROBOT_CLEARANCE, now - _SLACK))

    def _pair(
        self, first: str, second: str, rows: np.ndarray, others: np.ndarray
    ) -> tuple[InterRobotDistance, tuple[np.ndarray, np.ndarray]]:
        """Give the encounter of two arms, and their ways in its order."""
        turned = (first, second) not in self._encounters
        encounter = self._encounters[(second, first) if turned else (first, second)]
        encounter.refresh()
        return encounter, ((others, rows) if turned else (rows, others))


def _goes_on(arm: "MovingArm") -> bool:
    return arm.moving and not arm.stopping


def _delayed(arm: "MovingArm", trajectory: Trajectory, delay: float) -> Trajectory | None:
    """Let a motion start later; None where the arm moves and does not come to rest before it."""
    if delay <= 0.0:
        return trajectory
    if not arm.moving:
        return SequenceTrajectory([_rest(arm.q_ref, delay), trajectory])
    if isinstance(trajectory, SequenceTrajectory):  # it comes to rest first
        stop, *motion = trajectory.parts
        return SequenceTrajectory([stop, _rest(stop.end, delay), *motion])
    return None


def _rest(q: np.ndarray, duration: float) -> JointTrajectory:
    return JointTrajectory([MotionProfile([], duration, x) for x in q.tolist()])
