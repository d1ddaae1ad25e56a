"""PD control with the simulator's actuators."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from dm_control import mjcf

from bt_manip.control import ControlError, Controller, default_gains, gain_array
from bt_manip.robots import Robot, RobotModel

from .feedback import add_feedback

FEEDFORWARD_STEPS = 10
"""Number of control steps between updates of the feedforward torque."""


class NativePD(Controller):
    """PD control of each joint with MuJoCo's actuators, and feedforward from inverse dynamics.

    ``tau = Kp (q_ref - q) + Kd (v_ref - v) + tau_ff``, where ``tau_ff`` is the inverse dynamics of
    the reference, with payload and friction, updated in every tenth control step. The feedback is
    part of the model, so it uses the true state, and MuJoCo can advance many steps in one call, as
    batches of environments require. The tracking error is a few milliradians.

    It replaces the robot's motors by actuators with feedback when the model is built, so it has to
    be a run's first controller. Others can take over and hand back.
    """

    kind = "native_pd"
    saturates = True

    grippers: ClassVar[Mapping[str, str]] = {"two_finger": "native_two_finger"}
    """Kinds of grippers controlled by the simulator, by the described kind."""

    def _build(
        self,
        robot: Robot,
        kp: float | Sequence[float] | None = None,
        kd: float | Sequence[float] | None = None,
    ) -> None:
        """Give the robot's actuators their gains.

        Args:
            robot: The robot to control, not compiled yet.
            kp: Position gains [N m/rad]; default: those of `GravityCompensatedPD`.
            kd: Velocity gains [N m s/rad]; default: those of `GravityCompensatedPD`.

        Raises:
            ControlError: If a gain is negative, their number is not that of the joints, or the
                robot is already compiled.
        """
        super()._build(robot)
        if hasattr(robot, "mj_model"):
            raise ControlError(
                f"'{self.kind}' is part of the robot's model, so that a run cannot switch to it: "
                f"choose it as the first controller (--controller {self.kind})"
            )
        own, n = default_gains(robot.model_alone()), robot.limits.effort.size
        self._kp = gain_array("kp", own[0] if kp is None else kp, n)
        self._kd = gain_array("kd", own[1] if kd is None else kd, n)
        robot.arm_actuators = add_feedback(robot.arm_actuators, self._kp, self._kd)
        self._feedforward = np.zeros(n)
        self._age = 0  # control steps since the feedforward was computed

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model."""
        super().after_compile(physics, random_state)
        self._ctrl = physics.data.ptr.ctrl

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the reference for the next step."""
        fading = self._transfer_steps
        self.tau = tau = self._checked_torque()
        if fading or self._substitute is not None:
            self._drive(tau)
        else:
            reference = self.reference
            signal = self._signal(reference.q, reference.v, self._feedforward)
            self._ctrl[self.robot.ctrl_adr] = signal
        self._age = (self._age + 1) % FEEDFORWARD_STEPS

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the torques of the actuators [N m]."""  # (nv,)
        if self._age == 0:
            model = self.model
            self._feedforward = model.rnea(q_ref, v_ref, a_ref) + model.losses(v_ref)
        return self._kp * (q_ref - q) + self._kd * (v_ref - v) + self._feedforward

    def signals(
        self, model: RobotModel, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the control signals of many steps, equal to those of `before_substep` bit for bit.

        Args:
            model: The arm's model, with its payload.
            q_ref: Reference positions [rad].  # (n, nv)
            v_ref: Reference velocities [rad/s].  # (n, nv)
            a_ref: Reference accelerations [rad/s2].  # (n, nv)
        """  # (n, nv) [N m]
        n, every = len(q_ref), FEEDFORWARD_STEPS
        q, v, a = q_ref[::every], v_ref[::every], a_ref[::every]
        held = model.losses(v)
        for i, row in enumerate(held):
            row += model.rnea(q[i], v[i], a[i])
        return self._signal(q_ref, v_ref, np.repeat(held, every, axis=0)[:n])

    def _signal(self, q_ref: np.ndarray, v_ref: np.ndarray, tau: np.ndarray) -> np.ndarray:
        """Return the control signals, bit for bit the same for one step and for many."""
        return self._kp * q_ref + self._kd * v_ref + tau

    # State

    def reset(self) -> None:
        """Clear the state kept between steps."""
        super().reset()
        self._age = 0

    def get_state(self) -> dict[str, Any]:
        """Return the state, including the held feedforward."""
        held = {"feedforward": self._feedforward.tolist(), "age": self._age}
        return {**super().get_state(), **held}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state, including the held feedforward."""
        super().set_state(state)
        self._feedforward, self._age = np.array(state["feedforward"]), state["age"]
