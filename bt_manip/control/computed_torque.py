"""Computed torque: the controller that makes a robot follow to a milliradian."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.control.controller import Controller
from bt_manip.control.gains import per_joint
from bt_manip.robots import Robot


class ComputedTorque(Controller):
    """``tau = M (a_ref + Kp e + Ki int(e) + Kd de/dt) + bias + damping + friction``.

    The model cancels the arm's dynamics (rotor inertia, gravity and payload included), so the
    error of every joint follows the same linear equation, whatever the configuration. Gains are
    accelerations per error and need no tuning from robot to robot. The default puts three poles at
    -40 rad/s.

    Dry friction is compensated by where the reference moves, not by the measured velocity: that
    would chatter around rest.
    """

    kind = "computed_torque"

    def _build(
        self,
        robot: Robot,
        kp: float | Sequence[float] = 4800.0,
        ki: float | Sequence[float] = 64000.0,
        kd: float | Sequence[float] = 120.0,
        friction_velocity: float = 1e-2,
    ) -> None:
        """Set the gains.

        Args:
            robot: The robot to control.
            kp: Of the position error, for all joints or for each [1/s2].
            ki: Of the integral of the position error [1/s3].
            kd: Of the velocity error [1/s].
            friction_velocity: Reference speed at which dry friction is compensated by 76 %, being
                the argument 1 of a tanh [rad/s].

        Raises:
            ControlError: When a gain is negative, or their number is not that of the joints.
        """
        super()._build(robot)
        n = len(robot.description.arm_joints)
        self.kp, self.ki, self.kd = (
            per_joint(name, gain, n) for name, gain in (("kp", kp), ("ki", ki), ("kd", kd))
        )
        self._per_velocity = 1.0 / friction_velocity
        self._integral = np.zeros(n)  # [rad s]
        self._error = np.zeros(n)
        self._a = np.zeros(n)
        self._term = np.zeros(n)

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Give the efforts that make the error die out [N m]."""  # (nv,)
        model = self.model
        a, e, term = self._a, self._error, self._term
        np.subtract(q_ref, q, out=e)
        np.multiply(self.kp, e, out=a)
        np.add(a, a_ref, out=a)
        np.subtract(v_ref, v, out=term)
        np.multiply(term, self.kd, out=term)
        np.add(a, term, out=a)
        np.multiply(self.ki, self._integral, out=term)
        np.add(a, term, out=a)
        tau = pin.rnea(model.model, model.data, q, v, a)
        np.multiply(model.damping, v, out=term)
        np.add(tau, term, out=tau)
        np.multiply(v_ref, self._per_velocity, out=term)
        np.tanh(term, out=term)
        np.multiply(term, model.friction, out=term)
        np.add(tau, term, out=tau)
        return tau

    def before_substep(self, physics: Any, random_state: np.random.RandomState) -> None:
        """Command the efforts; integrate the error of the joints that no limit cuts."""
        super().before_substep(physics, random_state)
        # Where a limit cuts, integrating would only wind up what must later unwind.
        if self._cut:
            self._error[self.saturated] = 0.0
        np.multiply(self._error, self._dt, out=self._error)
        np.add(self._integral, self._error, out=self._integral)

    def reset(self) -> None:
        """Forget the integral."""
        super().reset()
        self._integral[:] = 0.0

    def get_state(self) -> dict[str, Any]:
        """Give the integral too."""
        return {**super().get_state(), "integral": self._integral.tolist()}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take back the integral too."""
        super().set_state(state)
        self._integral[:] = state["integral"]
