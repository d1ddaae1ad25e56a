"""Computed torque: the controller that makes a robot follow to a milliradian."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import mjcf

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
        gains = [per_joint(name, g, n) for name, g in (("kp", kp), ("kd", kd), ("ki", ki))]
        self.kp, self.kd, self.ki = gains
        # Products of a matrix and a stacked vector: NumPy takes as long for one as for one sum of
        # two vectors, and this is done a thousand times a second.
        self._stack = np.zeros(4 * n)
        self._e, self._edot, self._integral, self._a_ref = self._stack.reshape(4, n)
        self._product = np.zeros(2 * n)
        self._a, self._next_integral = self._product.reshape(2, n)
        self._per_velocity = np.full(n, 1.0 / friction_velocity)
        self._velocities = np.zeros(2 * n)
        self._v, self._direction = self._velocities.reshape(2, n)
        self._loss = np.zeros(n)

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model, and lay out the gains for its time step."""
        super().after_compile(physics, random_state)
        one, none = np.eye(len(self.kp)), np.zeros((len(self.kp), len(self.kp)))
        self._gains = np.block(
            [
                [np.diag(self.kp), np.diag(self.kd), np.diag(self.ki), one],  # the acceleration
                [self._dt * one, none, one, none],  # the next integral
            ]
        )

    def _model_changed(self) -> None:
        model = self.model
        self._pin, self._pin_data = model.model, model.data
        self._losses = np.hstack([np.diag(model.damping), np.diag(model.friction)])  # (n, 2 n)

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Give the efforts that make the error die out [N m]."""  # (nv,)
        if self._model is None:
            _ = self.model  # made when needed, the robot being compiled by then
        np.subtract(q_ref, q, self._e)
        np.subtract(v_ref, v, self._edot)
        self._a_ref[:] = a_ref
        self._gains.dot(self._stack, self._product)
        tau = pin.rnea(self._pin, self._pin_data, q, v, self._a)
        direction, loss = self._direction, self._loss
        self._v[:] = v
        np.multiply(v_ref, self._per_velocity, direction)
        np.tanh(direction, direction)
        self._losses.dot(self._velocities, loss)
        np.add(tau, loss, tau)
        return tau

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the efforts; integrate the error of the joints that no limit cuts."""
        super().before_substep(physics, random_state)
        if self._cut:
            # Where a limit cuts, integrating would only wind up what must later unwind.
            np.copyto(self._integral, self._next_integral, where=~self.saturated)
        else:
            self._integral[:] = self._next_integral

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
