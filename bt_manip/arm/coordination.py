"""Coordination of several arms in one cell: delayed starts and stops that avoid collisions."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from bt_manip.collision import (
    DISTANCE_TOLERANCE,
    INTER_ROBOT_CLEARANCE,
    INTER_ROBOT_STEP,
    InterRobotDistance,
    OtherRobot,
    RobotGeometry,
)
from bt_manip.exceptions import MotionError
from bt_manip.trajectories import JointTrajectory, MotionProfile, Trajectory

from .arm import Arm
from .motion_planning import in_sequence

DELAY_STEP = 0.1
"""Resolution of the delays of a motion while another arm passes [s]."""


class MultiArmCoordinator:
    """Keeps arms from colliding with each other, as long as each follows its reference.

    The future motion of every arm is known: the rest of its trajectory, then rest. At any time
    these motions keep the arms apart:

    - A new motion is planned around the configurations in which the other arms will come to rest,
      by the arm's own `CollisionWorld`, and compared with their motions over time. Where it would
      come too near to one, it starts later, at the latest when all others rest.
    - When the motion of an arm changes, because it is stopped or its speed scale changes, all
      pairs with it are checked again. Moving arms that would come too near to it are stopped; it
      is stopped itself where an arm at rest blocks it.

    Args:
        arms: The arms of one cell by the names of their robots; each has a collision world.
    """

    def __init__(self, arms: Mapping[str, Arm]) -> None:
        self._names = {arm: name for name, arm in arms.items()}
        geometry = {arm: RobotGeometry(arm.robot, arm.model) for arm in arms.values()}
        self._distances = {
            (a, b): InterRobotDistance(geometry[a], geometry[b])
            for a, b in combinations(arms.values(), 2)
        }
        for arm in arms.values():
            assert arm.world is not None
            arm.coordinator = self
            others = self._others(arm)
            arm.world.other_robots = tuple(
                OtherRobot(self._names[o], geometry[o], o) for o in others
            )

    def delay(self, arm: Arm, stop: Trajectory | None, motion: Trajectory | None) -> Trajectory:
        """Return a new motion, started as late as it takes to stay clear of the other arms.

        Args:
            arm: The arm.
            stop: How it comes to rest before the motion; None where the motion starts at once.
            motion: The motion; None where it only stops.

        Raises:
            MotionError: When another arm blocks the motion at any start.
        """
        trajectory = in_sequence(stop, motion)
        others = [other for other in self._others(arm) if other.moving]
        if not others or arm.speed_scale == 0.0:
            return trajectory
        latest = max(other.remaining for other in others)
        blocking: Arm | None = None
        for delay in (*np.arange(0.0, latest, DELAY_STEP).tolist(), latest):
            if delay > 0.0:
                if motion is None or (arm.moving and stop is None):
                    break
                trajectory = in_sequence(stop, _rest(stop.end if stop else arm.q, delay), motion)
            # While it still rests, the motions of the others have been planned around it.
            since = 0.0 if arm.moving else delay
            found = (other for other in others if self._collides(arm, trajectory, other, since))
            blocking = next(found, None)
            if blocking is None:
                return trajectory
        assert blocking is not None
        raise MotionError(f"'{self._names[blocking]}' blocks the motion", reason="robot")

    def motion_changed(self, arm: Arm) -> None:
        """Stop arms that would come too near to each other after an arm's motion has changed."""
        for other in self._others(arm):
            blocked, cause = arm, f"'{self._names[other]}' blocks the path"
            if _continues(other):
                blocked = other
                cause = f"'{self._names[arm]}' blocks the path: its motion has changed"
            if _continues(blocked) and self._will_collide(arm, other):
                blocked.stop(cause)

    def _others(self, arm: Arm) -> list[Arm]:
        return [other for other in self._names if other is not arm]

    def _collides(self, arm: Arm, trajectory: Trajectory, other: Arm, since: float) -> bool:
        """Tell whether a new motion comes too near to another arm while that one moves."""
        times = np.arange(since, other.remaining, INTER_ROBOT_STEP)
        if not len(times):
            return False
        path = trajectory.sample(np.minimum(arm.speed_scale * times, trajectory.duration))[0]
        distance, first, second = self._pair({arm: path, other: other.follower.ahead(times)})
        return distance.too_close(first, second, INTER_ROBOT_CLEARANCE)

    def _will_collide(self, arm: Arm, other: Arm) -> bool:
        """Tell whether two arms come too near to each other, or nearer than they are."""
        end = max(arm.remaining, other.remaining) + INTER_ROBOT_STEP
        times = np.arange(0.0, end, INTER_ROBOT_STEP)
        distance, first, second = self._pair(
            {one: one.follower.ahead(times) for one in (arm, other)}
        )
        now = distance.distance(first[0], second[0])
        return distance.too_close(
            first, second, min(INTER_ROBOT_CLEARANCE, now - DISTANCE_TOLERANCE)
        )

    def _pair(
        self, paths: Mapping[Arm, np.ndarray]
    ) -> tuple[InterRobotDistance, np.ndarray, np.ndarray]:
        """Return the distance of two arms, and their paths in its order."""
        first, second = (arm for arm in self._names if arm in paths)
        distance = self._distances[first, second]
        distance.refresh()
        return distance, paths[first], paths[second]


def _continues(arm: Arm) -> bool:
    return arm.moving and not arm.follower.stopping


def _rest(q: np.ndarray, duration: float) -> JointTrajectory:
    return JointTrajectory([MotionProfile([], duration, x) for x in q.tolist()])
