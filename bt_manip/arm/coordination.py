"""Coordination of several arms in one cell: delayed starts and stops that avoid collisions."""

from collections.abc import Iterator, Mapping
from itertools import combinations

import numpy as np

from bt_manip.collision import (
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

_DISTANCE_TOLERANCE = 1e-4  # [m]


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
    """

    def __init__(self, arms: Mapping[str, Arm]) -> None:
        """Coordinate arms.

        Args:
            arms: The arms of one cell by the names of their robots; each has a collision world.
        """
        self._arms = dict(arms)
        geometry = {name: RobotGeometry(arm.robot, arm.model) for name, arm in arms.items()}
        self._distances = {
            (a, b): InterRobotDistance(geometry[a], geometry[b]) for a, b in combinations(arms, 2)
        }
        for name, arm in arms.items():
            assert arm.world is not None
            arm.coordinator = self
            arm.world.other_robots = tuple(
                OtherRobot(other, geometry[other], arms[other]) for other in arms if other != name
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
        others = {name: other for name, other in self._others(arm) if other.moving}
        if not others or arm.speed_scale == 0.0:
            return trajectory
        latest = max(other.remaining for other in others.values())
        blocker = ""
        for delay in (*np.arange(0.0, latest, DELAY_STEP).tolist(), latest):
            if delay > 0.0:
                if motion is None or (arm.moving and stop is None):
                    break
                q = arm.q if stop is None else stop.end
                trajectory = in_sequence(stop, _rest(q, delay), motion)
            # While it still rests, the motions of the others have been planned around it.
            since = 0.0 if arm.moving else delay
            found = (n for n in others if self._collides(arm, trajectory, n, since))
            blocker = next(found, "")
            if not blocker:
                return trajectory
        raise MotionError(f"'{blocker}' blocks the motion", reason="robot")

    def motion_changed(self, arm: Arm) -> None:
        """Stop arms that would come too near to each other after an arm's motion has changed."""
        name = self._name(arm)
        for other_name, other in self._others(arm):
            if _continues(other):
                blocked, cause = other, f"'{name}' blocks the path: its motion has changed"
            else:
                blocked, cause = arm, f"'{other_name}' blocks the path"
            if _continues(blocked) and self._will_collide(name, other_name):
                blocked.stop(cause)

    def _name(self, arm: Arm) -> str:
        return next(name for name, known in self._arms.items() if known is arm)

    def _others(self, arm: Arm) -> Iterator[tuple[str, Arm]]:
        return ((name, other) for name, other in self._arms.items() if other is not arm)

    def _collides(self, arm: Arm, trajectory: Trajectory, other: str, since: float) -> bool:
        """Tell whether a new motion comes too near to another arm while that one moves."""
        times = np.arange(since, self._arms[other].remaining, INTER_ROBOT_STEP)
        if not len(times):
            return False
        path = trajectory.sample(np.minimum(arm.speed_scale * times, trajectory.duration))[0]
        distance, paths = self._pair(self._name(arm), other, path, self._arms[other].ahead(times))
        return distance.too_close(*paths, INTER_ROBOT_CLEARANCE)

    def _will_collide(self, first: str, second: str) -> bool:
        """Tell whether two arms come too near to each other, or nearer than they are."""
        arms = self._arms[first], self._arms[second]
        end = max(arm.remaining for arm in arms) + INTER_ROBOT_STEP
        times = np.arange(0.0, end, INTER_ROBOT_STEP)
        distance, paths = self._pair(first, second, *(arm.ahead(times) for arm in arms))
        now = distance.distance(paths[0][0], paths[1][0])
        return distance.too_close(*paths, min(INTER_ROBOT_CLEARANCE, now - _DISTANCE_TOLERANCE))

    def _pair(
        self, first: str, second: str, path: np.ndarray, other: np.ndarray
    ) -> tuple[InterRobotDistance, tuple[np.ndarray, np.ndarray]]:
        """Return the distance of two arms, and their paths in its order."""
        swapped = (first, second) not in self._distances
        distance = self._distances[(second, first) if swapped else (first, second)]
        distance.refresh()
        return distance, ((other, path) if swapped else (path, other))


def _continues(arm: Arm) -> bool:
    return arm.moving and not arm.stopping


def _rest(q: np.ndarray, duration: float) -> JointTrajectory:
    return JointTrajectory([MotionProfile([], duration, x) for x in q.tolist()])
