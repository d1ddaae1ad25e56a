"""Notice that something pushes the arm."""

from typing import Any

import numpy as np

from bt_manip.robots import Robot, RobotModel

EVERY = 7  # control steps between two looks
PATIENCE = 2  # looks in a row; a single one may be an impact of no consequence
SHARE = 0.03  # of a joint's effort limit that an unmeant effort has to exceed
AT_FIRST = 1.5  # times what presses on it when a motion begins
FRICTION = 2.2  # of a joint's dry friction, whose direction is uncertain around rest


class DeviationGuard:
    """Compares the efforts that make the arm move as it does with those of its motors.

    What is left of ``M a + bias - tau``, friction apart, is what others do to the arm: a push, or a
    contact. For the Panda the bounds are about what 10 N at its hand make.

    What presses on the arm already when a motion begins, as a table on what is gripped from it, is
    no deviation of that motion.

    Attributes:
        bounds: Largest effort of each joint that is no deviation [N m].  # (nq,)
    """

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        """Watch a robot.

        Args:
            robot: Its measured positions, velocities, accelerations and efforts are looked at.
            model: Its friction and its limits.
        """
        self._robot = robot
        self.bounds = SHARE * model.limits.effort + FRICTION * model.friction
        self._tolerated = self.bounds.copy()
        self._strikes = 0

    def begin(self, model: RobotModel) -> None:
        """Tolerate what there is when a motion begins."""
        self._tolerated = self.bounds + AT_FIRST * np.abs(self._foreign_effort(model))
        self._strikes = 0

    def look(self, model: RobotModel) -> str:
        """Look at the last control step.

        Args:
            model: The arm with its payload.

        Returns:
            What is wrong, once it is so for long enough; empty otherwise.
        """
        effort = self._foreign_effort(model)
        share = np.abs(effort) / self._tolerated
        if share.max() <= 1.0:
            self._strikes = 0
            return ""
        self._strikes += 1
        if self._strikes < PATIENCE:
            return ""
        joint = int(share.argmax())
        return (
            f"something pushes the arm: joint {joint + 1} takes {abs(effort[joint]):.1f} N m that "
            f"are not of its motion ({self._tolerated[joint]:.1f} N m are tolerated)"
        )

    def _foreign_effort(self, model: RobotModel) -> np.ndarray:
        """Give the efforts that nobody commanded, dry friction among them [N m]."""  # (nq,)
        robot = self._robot
        v = robot.v
        effort = model.rnea(robot.q, v, robot.a)
        effort += model.damping * v
        effort -= robot.tau
        return effort

    def get_state(self) -> dict[str, Any]:
        """Give what is remembered between looks as plain data."""
        return {"tolerated": self._tolerated.tolist(), "strikes": self._strikes}

    def set_state(self, state: dict[str, Any]) -> None:
        """Take back what `get_state` gave."""
        self._tolerated, self._strikes = np.array(state["tolerated"]), state["strikes"]
