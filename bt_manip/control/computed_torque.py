"""Computed torque: the controller that makes a robot follow to a milliradian."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from dm_control import mjcf
from numpy import add, frombuffer, tanh
from pinocchio import rnea

from bt_manip.control.controller import Controller
from bt_manip.control.gains import per_joint
from bt_manip.robots import Robot

join = b"".join


class ComputedTorque(Controller):
    """Cancel the arm's dynamics, and let errors die out alike in all joints.

    ``tau = M (a_ref + Kp e + Ki int(e) + Kd de/dt) + bias + damping + friction``

    The model cancels the arm's dynamics (rotor inertia, gravity and payload included), so the
    error of every joint follows the same linear equation, whatever the configuration. Gains are
    accelerations per error and need no tuning from robot to robot. The default puts three poles at
    -40 rad/s.

    Dry friction is compensated by where the reference moves, not by the measured velocity: that
    would chatter around rest.
    """

    kind = "computed_torque"
    cuts_to_limits = True

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
        self._friction_velocity = friction_velocity
        self._stack = np.zeros(6 * n)
        self._product = np.zeros(4 * n)
        self._a, self._integral, self._direction, _ = self._product.reshape(4, n)
        self._losses = self._product[2 * n :]
        self._loss = np.zeros(n)

    def _lay_out(self) -> None:
        """Write the law as two matrices.

        A product of a small matrix and a vector takes NumPy as long as a sum of two vectors, and
        the law has a dozen of those: this way it costs a third, a thousand times a second.
        """
        model, n = self.model, len(self.kp)
        one, none = np.eye(n), np.zeros((n, n))
        kp, kd, ki = np.diag(self.kp), np.diag(self.kd), np.diag(self.ki)
        dt, steep = self._dt * one, one / self._friction_velocity
        damping = np.diag(model.damping)
        law = np.block(
            [  # q_ref, q,  v_ref, v,       a_ref, integral
                [kp, -kp, kd, -kd, one, ki],  # commanded acceleration
                [dt, -dt, none, none, none, one],  # integral, a step on
                [none, none, steep, none, none, none],  # direction of the friction, before tanh
                [none, none, none, damping, none, none],  # damping
            ]
        )
        friction = np.hstack([np.diag(model.friction), one])  # direction, damping -> effort
        # Together, because looking up attributes one by one takes as long as a product.
        self._bound = (
            model.model, model.data, law, self._product, self._a, self._integral,
            friction, self._direction, self._losses, self._loss,
        )  # fmt: skip

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model, whose time step is part of the law."""
        super().after_compile(physics, random_state)
        self._lay_out()

    def _model_changed(self) -> None:
        self._lay_out()

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Give the efforts that make the error die out [N m]."""  # (nv,)
        if self._model is None:
            _ = self.model  # made when needed, the robot being compiled by then
        pin, data, law, product, a, integral, friction, direction, losses, loss = self._bound
        # Joined as bytes: a quarter of the time of writing into parts of an array.
        parts: Any = (q_ref, q, v_ref, v, a_ref, integral)
        self._stack = stack = frombuffer(join(parts))
        law.dot(stack, product)
        tau = rnea(pin, data, q, v, a)
        tanh(direction, direction)
        friction.dot(losses, loss)
        add(tau, loss, tau)
        return tau

    def _were_cut(self) -> None:
        """Do not integrate the error of joints that a limit cuts: that must unwind later."""
        former = self._stack[-len(self._integral) :]
        np.copyto(self._integral, former, where=self.saturated)

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
