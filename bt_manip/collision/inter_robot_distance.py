"""Whether two robots come too near to each other."""

import mujoco
import numpy as np

from .robot_geometry import RobotGeometry
from .scratch_model import restrict_pairs, scratch_model

INTER_ROBOT_CLEARANCE = 10e-3
"""Distance that robots keep from each other [m]: what both may be off, and a little more."""

INTER_ROBOT_STEP = 2e-3
"""Time between the moments that are looked at where two robots are near [s]."""

FAR = 70e-3
"""Distance beyond which only each tenth moment is looked at [m].

In the half of these 20 ms two robots at 2.5 m/s, which the tools of fast arms reach, come nearer by
50 mm.
"""

_STRIDE = 10


class InterRobotDistance:
    """Measures how near two robots, with what they hold, are to each other."""

    def __init__(self, first: RobotGeometry, second: RobotGeometry) -> None:
        """Look at two robots.

        Args:
            first: The one.
            second: The other, of the same physics.
        """
        self._figures = first, second
        self._robot = first.robot
        self._source: mujoco.MjModel | None = None
        self._seen: tuple[np.ndarray, np.ndarray] | None = None
        self.refresh()

    def refresh(self) -> None:
        """Take over what both hold, and where everything else is."""
        first, second = self._figures
        for figure in self._figures:
            figure.refresh()
        seen = first.bodies, second.bodies
        if self._robot.mj_model is not self._source:
            self._source = self._robot.mj_model
            self._model = scratch_model(self._source, FAR)
            self._data = mujoco.MjData(self._model)
            self._seen = None
        if self._seen is None or any(a is not b for a, b in zip(seen, self._seen, strict=True)):
            self._seen = seen
            solid = (self._source.geom_contype | self._source.geom_conaffinity) != 0
            of_geom = self._source.geom_bodyid
            one, other = (figure.bodies[of_geom] & solid for figure in self._figures)
            self._between = (one[:, np.newaxis] & other) | (other[:, np.newaxis] & one)
            restrict_pairs(self._model, self._between)
        self._data.qpos[:] = self._robot.mj_data.qpos
        for figure in self._figures:
            figure.spread(self._data.qpos)

    def distance(self, q_first: np.ndarray, q_second: np.ndarray) -> float:
        """Give the distance between both robots [m], `FAR` where it is not less.

        Args:
            q_first: Positions of the joints of the one [rad].  # (nq,)
            q_second: And of the other.  # (nq,)
        """
        first, second = self._figures
        first.put(self._data.qpos, q_first)
        second.put(self._data.qpos, q_second)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        if not self._data.ncon:
            return FAR
        contact = self._data.contact
        geoms = contact.geom
        between = self._between[geoms[:, 0], geoms[:, 1]]
        # Less than what the model has for a margin: the physics pushes from there on.
        distance = (contact.dist - contact.includemargin)[between]
        return float(distance.min(initial=0.0)) + FAR

    def too_close(self, first: np.ndarray, second: np.ndarray, needed: float) -> bool:
        """Tell whether two robots come too near to each other on their ways.

        Args:
            first: Positions of the joints of the one, every `INTER_ROBOT_STEP` [rad].  # (n, nq)
            second: Those of the other, at the same times.  # (n, nq)
            needed: Distance that is near enough [m].
        """
        n = len(first)
        for middle in range(0, n + _STRIDE - 1, _STRIDE):
            middle = min(middle, n - 1)
            distance = self.distance(first[middle], second[middle])
            if distance < needed:
                return True
            if distance >= FAR:
                continue
            half = _STRIDE // 2
            for i in range(max(0, middle - half), min(n, middle + half + 1)):
                if i != middle and self.distance(first[i], second[i]) < needed:
                    return True
        return False
