"""Computed torque control."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from dm_control import mjcf
from numpy import add, frombuffer, tanh
from pinocchio import rnea

from bt_manip.robots import Robot, RobotModel

from .controller import Controller
from .pd_law import gain_array, inverse_inertias, smallest_inertia

join = b"".join

MIN_INERTIA = 8e-4
"""Minimum inertia of a joint assumed by the feedback, over the effort limit [kg m2 / N m].

With the default gains the motor saturates at an error of 0.26 rad. The inertia of industrial arms
is usually larger.
"""

MAX_INERTIA_RATIO = 8.0
"""Largest ratio of assumed and true inertia. With the default velocity gain and steps of 1 ms, the
velocity error vanishes in one step; from twice this ratio on it would oscillate."""


class ComputedTorque(Controller):
    """Inverse dynamics control with PID feedback on joint acceleration.

    ``tau = M (a_ref + Kp e + Ki int(e) + Kd de/dt) + bias + damping + friction``

    The model compensates the arm's dynamics, including rotor inertia, gravity and payload, so that
    the error of each joint follows the same linear differential equation in all configurations.
    Gains are accelerations per error and need no tuning per robot. The defaults place three poles
    at -40 rad/s. The tracking error is about one milliradian.

    The stiffness of a joint, inertia times ``kp``, nearly vanishes for light links without rotor
    inertia. The feedback of such joints assumes more inertia (`MIN_INERTIA`), up to the limit of
    the control step (`MAX_INERTIA_RATIO`).

    Dry friction is compensated using the reference velocity; with the measured velocity, the torque
    would chatter at rest.
    """

    kind = "computed_torque"
    saturates = True

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
            kp: Position gains, one number or one per joint [1/s2].
            ki: Integral gains [1/s3].
            kd: Velocity gains [1/s].
            friction_velocity: Reference speed at which dry friction is compensated by 76 %, the
                tanh of 1 [rad/s].

        Raises:
            ControlError: If a gain is negative, or their number is not that of the joints.
        """
        super()._build(robot)
        n = len(robot.description.arm_joints)
        gains = [gain_array(name, g, n) for name, g in (("kp", kp), ("kd", kd), ("ki", ki))]
        self.kp, self.kd, self.ki = gains
        self._friction_velocity = friction_velocity
        self._stack = np.zeros(6 * n)
        self._product = np.zeros(4 * n)
        self._a, self._integral, self._direction, _ = self._product.reshape(4, n)
        self._losses = self._product[2 * n :]
        self._loss = np.zeros(n)
        self._added: np.ndarray | None = None

    def _build_law(self) -> None:
        """Build the control law from two matrices.

        NumPy multiplies a small matrix and a vector in the time of an addition of two vectors, of
        which the law has a dozen: this form takes a third of the time.
        """
        model, n = self.model, len(self.kp)
        one, none = np.eye(n), np.zeros((n, n))
        kp, kd, ki = np.diag(self.kp), np.diag(self.kd), np.diag(self.ki)
        dt, steep = self._dt * one, one / self._friction_velocity
        damping = np.diag(model.damping)
        if self._added is None:  # without payload, which only increases the true inertia
            self._added = added_inertia(model)
        added = np.diag(self._added)
        law = np.block(
            [  # q_ref, q,  v_ref, v,       a_ref, integral
                [kp, -kp, kd, -kd, one, ki],  # commanded acceleration
                [dt, -dt, none, none, none, one],  # integral after the step
                [none, none, steep, none, none, none],  # direction of the friction, before tanh
                # torque of the damping, and of the feedback on the added inertia
                [added @ kp, -added @ kp, added @ kd, damping - added @ kd, none, added @ ki],
            ]
        )
        friction = np.hstack([np.diag(model.friction), one])  # direction, damping -> torque
        # One tuple: looking up an attribute takes as long as a product.
        self._bound = (
            model.model, model.data, law, self._product, self._a, self._integral,
            friction, self._direction, self._losses, self._loss,
        )  # fmt: skip

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model and its time step."""
        super().after_compile(physics, random_state)
        self._build_law()

    def _on_model_change(self) -> None:
        self._build_law()

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the computed torques [N m]."""  # (nv,)
        if self._model is None:
            _ = self.model  # builds the law
        pin, data, law, product, a, integral, friction, direction, losses, loss = self._bound
        # Joining bytes takes a quarter of the time of assigning slices.
        parts: Any = (q_ref, q, v_ref, v, a_ref, integral)
        self._stack = stack = frombuffer(join(parts))
        law.dot(stack, product)
        tau = rnea(pin, data, q, v, a)
        tanh(direction, direction)
        friction.dot(losses, loss)
        add(tau, loss, tau)
        return tau

    def _on_saturation(self) -> None:
        """Do not integrate the errors of saturated joints (anti-windup)."""
        before = self._stack[-len(self._integral) :]
        np.copyto(self._integral, before, where=self.saturated)

    def reset(self) -> None:
        """Clear the state, including the integral."""
        super().reset()
        self._integral[:] = 0.0

    def get_state(self) -> dict[str, Any]:
        """Return the state, including the integral."""
        return {**super().get_state(), "integral": self._integral.tolist()}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state, including the integral."""
        super().set_state(state)
        self._integral[:] = state["integral"]


def added_inertia(model: RobotModel) -> np.ndarray:
    """Return the inertia added by the feedback of each joint, nonzero for light joints [kg m2].

    Args:
        model: The arm with its payload.
    """  # (nq,)
    needed = MIN_INERTIA * model.limits.effort
    inverses = inverse_inertias(model)
    inertia = smallest_inertia(inverses)
    added = np.minimum(needed, MAX_INERTIA_RATIO * inertia) - inertia
    added = np.maximum(added, 0.0)
    roots = np.sqrt(added)[:, np.newaxis]
    largest = max(np.linalg.eigvalsh(roots * inverse * roots.T).max() for inverse in inverses)
    return added * min(1.0, (MAX_INERTIA_RATIO - 1.0) / max(largest, 1e-12))
