"""Distance between two robots, at configurations and along motions."""

import mujoco
import numpy as np

from .collision_model import CollisionModel
from .robot_geometry import RobotGeometry

INTER_ROBOT_CLEARANCE = 10e-3  # [m] between robots: the tracking errors of both, and a reserve
INTER_ROBOT_STEP = 2e-3  # [s] between the samples of two motions
MAX_DISTANCE = 70e-3
"""Distance beyond which only every `_STRIDE`-th sample is checked [m].

In half of these 20 ms, two robots whose tools move at 2.5 m/s approach by 50 mm.
"""
_STRIDE = 10  # samples


class InterRobotDistance:
    """Measures the distance between two robots of one cell, including their held objects."""

    def __init__(self, first: RobotGeometry, second: RobotGeometry) -> None:
        self._robots = first, second
        self._source: mujoco.MjModel | None = None
        self._bodies: tuple[np.ndarray, ...] = ()
        self.refresh()

    def refresh(self) -> None:
        """Update the state of the cell and the held objects of both robots."""
        robot = self._robots[0].robot
        for geometry in self._robots:
            geometry.refresh()
        bodies = tuple(geometry.bodies for geometry in self._robots)
        if robot.mj_model is not self._source:
            self._source, self._bodies = robot.mj_model, ()
            self._model = CollisionModel(self._source, MAX_DISTANCE)
        if not self._bodies or any(a is not b for a, b in zip(bodies, self._bodies, strict=True)):
            self._bodies = bodies
            solid = (self._source.geom_contype | self._source.geom_conaffinity) != 0
            first, second = (mask[self._source.geom_bodyid] & solid for mask in bodies)
            self._between = (first[:, np.newaxis] & second) | (second[:, np.newaxis] & first)
            self._model.restrict_to(self._between)
        self._model.copy_state(robot.mj_data)
        for geometry in self._robots:
            geometry.write_open_gripper(self._model.data.qpos)

    def distance(self, q_first: np.ndarray, q_second: np.ndarray) -> float:
        """Return the distance between both robots [m], at most `MAX_DISTANCE`.

        Args:
            q_first: Configuration of the first robot [rad].  # (nq,)
            q_second: Configuration of the second robot [rad].  # (nq,)
        """
        for geometry, q in zip(self._robots, (q_first, q_second), strict=True):
            geometry.write(self._model.data.qpos, q)
        if not self._model.collide():
            return MAX_DISTANCE
        first, second, distance = self._model.contacts
        return float(distance[self._between[first, second]].min(initial=MAX_DISTANCE))

    def too_close(self, first: np.ndarray, second: np.ndarray, clearance: float) -> bool:
        """Return whether the robots come closer than a clearance during two motions.

        Args:
            first: Configurations of the first robot, every `INTER_ROBOT_STEP` [rad].  # (n, nq)
            second: Configurations of the second robot at the same times [rad].  # (n, nq)
            clearance: Required distance [m].
        """
        n = len(first)
        for middle in range(0, n + _STRIDE - 1, _STRIDE):
            middle = min(middle, n - 1)
            distance = self.distance(first[middle], second[middle])
            if distance < clearance:
                return True
            if distance >= MAX_DISTANCE:
                continue
            half = _STRIDE // 2
            for i in range(max(0, middle - half), min(n, middle + half + 1)):
                if i != middle and self.distance(first[i], second[i]) < clearance:
                    return True
        return False
