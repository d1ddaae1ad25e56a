"""Notice that something pushes the arm."""

from typing import Any

import numpy as np

from bt_manip.robots import Robot, RobotModel

EVERY = 7  # control steps between two looks
PATIENCE = 2  # looks in a row in which a joint takes too much
LASTING = 7e-3  # [s] a blow is one that a tolerated effort would take longer for
SHARE = 0.03  # of a joint's effort limit that an unmeant effort has to exceed
AT_FIRST = 1.5  # times what presses on it when a motion begins
FRICTION = 2.2  # of a joint's dry friction, whose direction is uncertain around rest


class DeviationGuard:
    """Compares the efforts that make the arm move as it does with those of its motors.

    What is left of ``M a + bias - tau``, friction apart, is what others do to the arm: a push, or a
    contact. For the Panda the bounds are about what 10 N at its hand make. A blow is over before
    anybody looks, but it leaves the arm at another velocity than that of its reference: ``M`` times
    what came to that difference since the last look is the blow's impulse, as far as the motors did
    not make it. A controller that follows badly makes much of it, and always towards the
    difference; one that follows well only works against it.

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
        self._error, self._astray = np.zeros((2, model.nq))

    def begin(self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray) -> None:
        """Tolerate what there is when a motion begins.

        Args:
            model: The arm with its payload.
            v_ref: Velocity of its reference [rad/s].  # (nq,)
            a_ref: Acceleration of its reference [rad/s2].  # (nq,)
        """
        robot = self._robot
        effort = model.rnea(robot.q, robot.v, robot.a) - self._commanded(model)
        self._tolerated = self.bounds + AT_FIRST * np.abs(effort)
        self._strikes = 0
        self._error = robot.v - v_ref
        self._astray = self._commanded(model) - model.rnea(robot.q, robot.v, a_ref)

    def look(self, model: RobotModel, v_ref: np.ndarray, a_ref: np.ndarray, dt: float) -> str:
        """Look at the last control step, and at what has come of those since the last look.

        Args:
            model: The arm with its payload.
            v_ref: Velocity of its reference after that step [rad/s].  # (nq,)
            a_ref: Acceleration of its reference after that step [rad/s2].  # (nq,)
            dt: Duration of a control step [s].

        Returns:
            What is wrong, once it is so for long enough; empty otherwise.
        """
        robot = self._robot
        q, v = robot.q, robot.v
        commanded, expected = self._commanded(model), model.rnea(q, v, a_ref)
        effort = model.rnea(q, v, robot.a) - commanded
        astray, error = commanded - expected, v - v_ref
        change = model.rnea(q, v, a_ref + (error - self._error)) - expected
        impulse = _unexplained(change, EVERY * dt * self._astray, EVERY * dt * astray)
        self._error, self._astray = error, astray
        share, blow = np.abs(effort) / self._tolerated, np.abs(impulse) / self._tolerated
        if blow.max() > LASTING:
            joint = int(blow.argmax())
            return (
                f"something pushes the arm: joint {joint + 1} takes {abs(impulse[joint]):.2f} N m s"
                f" at once ({LASTING * self._tolerated[joint]:.2f} N m s are tolerated)"
            )
        self._strikes = 0 if share.max() <= 1.0 else self._strikes + 1
        if self._strikes < PATIENCE:
            return ""
        joint = int(share.argmax())
        return (
            f"something pushes the arm: joint {joint + 1} takes {abs(effort[joint]):.1f} N m that "
            f"are not of its motion ({self._tolerated[joint]:.1f} N m are tolerated)"
        )

    def _commanded(self, model: RobotModel) -> np.ndarray:
        """Give what the motors make, dry friction included, damping not [N m]."""  # (nq,)
        return self._robot.tau - model.damping * self._robot.v

    def get_state(self) -> dict[str, Any]:
        """Give what is remembered between looks as plain data."""
        return {
            "tolerated": self._tolerated.tolist(),
            "strikes": self._strikes,
            "error": self._error.tolist(),
            "astray": self._astray.tolist(),
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Take back what `get_state` gave."""
        self._tolerated, self._strikes = np.array(state["tolerated"]), state["strikes"]
        self._error, self._astray = np.array(state["error"]), np.array(state["astray"])


def _unexplained(change: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Give what is left of a change of momentum without what the motors made of it [N m s].

    Args:
        change: The change.  # (nq,)
        before: What the motors would have made, going on as at the last look.  # (nq,)
        after: What they would have made, had they always been as they are now.  # (nq,)
    """
    towards = np.sign(change)
    made = np.maximum(towards * before, towards * after).clip(min=0.0)
    return change - towards * np.minimum(made, np.abs(change))
