"""The base class of arm controllers."""

import abc
from collections.abc import Callable, Mapping, Sequence
from operator import le
from typing import Any, ClassVar

import numpy as np
from dm_control import composer, mjcf
from numpy import ndarray

from bt_manip.robots import Payload, Robot, RobotModel, writer

from .exceptions import ControlError, ControllerFault
from .pd_law import compliant_torque, default_gains, pd_torque
from .reference import Hold, Reference

FLOAT = np.dtype(np.float64)

TRANSFER_TIME = 0.1
"""Time over which the torque difference between two controllers is faded out [s].

Two torques within the effort limits differ by at most twice the limit. Faded out linearly in 100
control steps of 1 ms, the largest difference changes by 2 % of the limit per step.
"""


Law = Callable[[ndarray, ndarray, ndarray, ndarray, ndarray], ndarray]
"""Function of q, v, q_ref, v_ref and a_ref that returns torques, as `Controller.compute`."""


class Controller(composer.Entity):
    """Computes the joint torques for a robot's arm to follow a reference, in each physics step.

    A controller is attached to its robot (``robot.attach(controller)``) or run by a
    `ControllerManager`. A subclass implements ``compute``, and ``get_state`` and ``set_state`` if
    it keeps state between steps.

    Torques are checked before they are commanded. If ``compute`` raises an error, or returns
    torques that are not finite, of the wrong number or beyond the effort limits, a PD controller
    with gravity compensation takes over immediately and the step raises a `ControllerFault`, so
    that the arm can still be stopped. While a measured position or velocity is not finite, it is
    replaced by the reference, and the joint moves without feedback.

    While the reference is `compliant`, soft springs and dampers with gravity compensation replace
    ``compute``, without integral action.
    """

    kind: ClassVar[str] = "controller"

    saturates: ClassVar[bool] = False
    """Whether torques beyond the effort limits are clipped and counted, rather than a fault."""

    def _build(self, robot: Robot) -> None:
        """Initialize the control of a robot's arm; subclasses add their gains."""
        self._mjcf_root = mjcf.RootElement(model=self.kind)
        self.robot = robot
        """The controlled robot."""
        self._limit = np.array(robot.limits.effort)
        self._bounds = self._limit.tolist()
        self._shape = self._limit.shape
        self._fault = self._compliant = False
        self._bare: RobotModel | None = None
        self._base = b""  # pose of the robot's base in the model
        self._model: RobotModel | None = None
        self._payload: Payload | None = None
        self._reference: Reference | None = None
        self._carried: Payload | None = None  # the reference's payload when it was last read
        self._substitute: Law | None = None  # replaces compute after a fault and while compliant
        self._clipped = False
        self._transfer = np.zeros_like(self._limit)  # [N m] torque difference at the take-over
        self._transfer_steps = 0  # control steps until it is faded out
        self.tau = np.zeros_like(self._limit)
        """Torques of the last step, within the effort limits [N m]."""  # (nv,)
        self.saturated = np.zeros(self._limit.shape, dtype=bool)
        """Joints whose torque was clipped in the last step."""  # (nv,)
        self.saturated_steps = 0
        """Number of steps in which a torque was clipped."""

    @abc.abstractmethod
    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the joint torques of one step, before the limits are applied [N m].

        Args:
            q: Measured positions [rad].  # (nv,)
            v: Measured velocities [rad/s].  # (nv,)
            q_ref: Reference positions [rad].  # (nv,)
            v_ref: Reference velocities [rad/s].  # (nv,)
            a_ref: Reference accelerations [rad/s2].  # (nv,)
        """  # (nv,)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """An empty model for composer to attach."""
        return self._mjcf_root

    @property
    def model(self) -> RobotModel:
        """The arm's model, including the payload."""
        if self._model is None:
            # From the bare model, so that equal payloads give equal models bit for bit.
            self._model = self.bare_model.with_payload(self._payload)
            self._on_model_change()
        return self._model

    @property
    def bare_model(self) -> RobotModel:
        """The arm's model without payload and overrides; created when the robot is compiled.

        Raises:
            ControlError: If it is not compiled yet.
        """
        if self._bare is None:
            raise ControlError("a controller has no model before its robot is compiled")
        return self._bare

    def share_model(self, other: "Controller") -> None:
        """Use the model of another controller of the robot, as overrides may be active now."""
        self._bare, self._base = other._bare, other._base

    @property
    def payload(self) -> Payload | None:
        """Payload included in the model."""
        return self._payload

    @payload.setter
    def payload(self, payload: Payload | None) -> None:
        self._payload = payload
        self._model = None

    @property
    def reference(self) -> Reference:
        """The reference; by default the measured configuration at its first use.

        Raises:
            ControlError: If a new reference lacks an attribute of `Reference`, or its arrays have
                the wrong shape or type.
        """
        if self._reference is None:
            self._reference = Hold(self.robot.q)
        return self._reference

    @reference.setter
    def reference(self, reference: Reference | None) -> None:
        if reference is not None:
            # The check of the class takes a hundredth of the time of a check of all attributes.
            derived = Reference in type(reference).__mro__
            if not derived and not isinstance(reference, Reference):
                raise ControlError(
                    "a reference has the attributes of bt_manip.control.Reference: derive "
                    f"{type(reference).__name__} from it"
                )
            for name in ("q", "v", "a"):
                x = getattr(reference, name)
                if x.shape != self._limit.shape or x.dtype != np.float64:
                    raise ControlError(
                        f"a reference's {name} is {len(self._limit)} numbers of type float64, "
                        f"one a joint, got {x.dtype} {x.shape}"
                    )
        self._reference = reference

    # Composer's hooks

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model."""
        model, data = physics.model.ptr, physics.data.ptr
        robot = self.robot
        self._data = data
        root = model.body_rootid[robot.wrist_body_id]
        base = model.body_pos[root].tobytes() + model.body_quat[root].tobytes()
        if base != self._base:  # first, or moved
            self._base, self._bare, self._model = base, robot.make_model(), None
        self._dt = float(model.opt.timestep)
        # Bound once: look-ups in MuJoCo's data would take longer than the computation.
        self._drive = write = writer(data.ctrl, robot.ctrl_adr)
        feedback = model.actuator_biasprm[robot.ctrl_adr, 1:3].T  # of a native controller
        if feedback.any():
            q, v = data.qpos, data.qvel
            of_q, of_v = feedback[0].copy(), feedback[1].copy()
            at_q, at_v = robot.qpos_adr, robot.dof_adr
            self._drive = lambda tau: write(tau - of_q * q[at_q] - of_v * v[at_v])

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Reset all state."""
        self.reset()
        if isinstance(self._reference, Hold):
            self._reference = None

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the torques for the next step."""
        self.tau = tau = self._checked_torque()
        self._drive(tau)

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Advance the reference."""
        (self._reference or self.reference).advance(self._dt)

    # Torques

    def _checked_torque(self) -> np.ndarray:
        """Return the torques for the present state, within the limits [N m].

        Raises:
            ControllerFault: If they are invalid.
        """  # (nv,)
        robot, reference = self.robot, self._reference or self.reference
        if reference.payload is not self._carried:
            self.payload = self._carried = reference.payload
        if reference.compliant is not self._compliant:
            self._set_compliant(reference.compliant)
        q, v = robot.read_q(), robot.read_v()
        try:
            return self._torque(q, v, reference)
        except _InvalidTorque as invalid:
            measured = np.isfinite(q), np.isfinite(v)
            if all(known.all() for known in measured):
                raise self._fall_back(invalid) from invalid.__cause__
        q, v = np.where(measured[0], q, reference.q), np.where(measured[1], v, reference.v)
        if self._substitute is None:
            commanded = self.tau, self.saturated_steps
            self.reset()  # integrals are not finite either
            self.tau, self.saturated_steps = commanded
        try:
            return self._torque(q, v, reference)
        except _InvalidTorque as invalid:
            raise self._fall_back(invalid) from invalid.__cause__

    def _torque(self, q: np.ndarray, v: np.ndarray, reference: Reference) -> np.ndarray:
        """Return the torques for a state, within the limits [N m].

        Raises:
            _InvalidTorque: If they cannot be commanded.
        """  # (nv,)
        try:
            law = self._substitute or self.compute
            tau = law(q, v, reference.q, reference.v, reference.a)
        except (Exception, SystemExit) as error:
            text = " ".join(str(error).split())
            raise _InvalidTorque(f"raised {type(error).__name__}: {text}") from error
        if type(tau) is not ndarray or tau.dtype is not FLOAT or tau.shape != self._shape:
            tau = self._as_torques(tau)
        # Compared one by one, faster than NumPy for so few; NaN is never within the limit.
        if not all(map(le, map(abs, tau.tolist()), self._bounds)):
            tau = self._clip(tau)
        elif self._clipped:
            self._clipped = self.saturated[:] = False
        return self._with_transfer(tau) if self._transfer_steps else tau

    def _as_torques(self, tau: Any) -> np.ndarray:
        """Convert an array of another number type.

        Raises:
            _InvalidTorque: If it is not an array of numbers.
        """
        shaped = isinstance(tau, ndarray) and tau.shape == self._shape and tau.dtype.kind in "fiu"
        if not shaped:
            found = f"a value of type {type(tau).__name__}"
            if isinstance(tau, ndarray):
                found = f"{tau.dtype} of shape {tau.shape}"
            raise _InvalidTorque(
                f"returned {found}, expected an array of {self._shape[0]} torques, one a joint"
            )
        return tau.astype(FLOAT)

    def _clip(self, tau: np.ndarray) -> np.ndarray:
        """Clip torques to the limits and count the step.

        Raises:
            _InvalidTorque: If they are not finite, or the controller does not clip.
        """
        limited = np.maximum(np.minimum(tau, self._limit), -self._limit)
        np.not_equal(limited, tau, out=self.saturated)
        self._clipped = bool(self.saturated.any())
        if self._clipped:
            names = self.robot.description.arm_joints
            saturates = self.saturates or self._substitute is not None
            problem = _torque_problem(tau, self._limit, names, saturates=saturates)
            if problem:
                raise _InvalidTorque(problem)
            self.saturated_steps += 1
            self._on_saturation()
        return limited

    def _fall_back(self, problem: object) -> ControllerFault:
        """Replace ``compute`` by a PD controller; return the exception to raise."""
        self._fault = True
        model = self.bare_model.with_payload(self._payload)
        kp, kd = default_gains(model)
        self._substitute = lambda q, v, q_ref, v_ref, a_ref: pd_torque(
            model, kp, kd, q, v, q_ref, v_ref
        )
        return ControllerFault(self.kind, type(self).__module__, str(problem), self._data.time)

    def _become_compliant(self) -> None:
        """Replace ``compute`` by soft springs and dampers."""
        self._compliant = True
        self._substitute = lambda q, v, q_ref, v_ref, a_ref: compliant_torque(
            self.model, self._limit, q, v, q_ref
        )

    def _set_compliant(self, compliant: bool) -> None:
        """Become compliant, or return to ``compute`` without a step in torque."""
        if self._fault:  # the PD controller stays
            self._compliant = compliant
            return
        commanded, saturated_steps = self.tau, self.saturated_steps
        self.reset()
        if compliant:
            self._become_compliant()
        else:
            self._transfer_from(commanded)
        self.tau, self.saturated_steps = commanded, saturated_steps

    # Bumpless transfer

    def take_over(self, previous: "Controller") -> None:
        """Continue from another controller of the robot without a step in torque.

        The difference between the torques of both controllers for the present state is added to the
        new torque and faded out linearly over `TRANSFER_TIME`. A reference at rest continues from
        the measured configuration (`Reference`), so that no error of the previous controller
        remains.

        Raises:
            ControllerFault: If either controller fails.
        """
        commanded, saturated_steps = previous.tau.copy(), previous.saturated_steps
        tau, reference = previous._checked_torque(), previous.reference
        reference.hold_at(self.robot.q)
        self.reference, self.payload = reference, previous.payload
        self._carried = previous._carried
        self.reset()
        self._transfer_from(tau)
        self.tau, self.saturated_steps = commanded, saturated_steps

    def _transfer_from(self, tau: np.ndarray) -> None:
        """Fade from given torques [N m] to its own."""
        self._transfer = tau - self._checked_torque()
        self.reset()  # the evaluation must not affect integrals
        self._transfer_steps = round(TRANSFER_TIME / self._dt)

    def _with_transfer(self, tau: np.ndarray) -> np.ndarray:
        """Add the remaining torque difference of a take-over."""
        remaining = self._transfer_steps * self._dt / TRANSFER_TIME
        self._transfer_steps -= 1
        tau = tau + remaining * self._transfer
        return np.maximum(np.minimum(tau, self._limit), -self._limit)

    # State

    def reset(self) -> None:
        """Clear the state kept between steps."""
        self._fault = self._compliant = False
        self._substitute = None
        self.tau = np.zeros_like(self._limit)
        self.saturated[:] = self._clipped = False
        self.saturated_steps = self._transfer_steps = 0

    def get_state(self) -> dict[str, Any]:
        """Return the state kept between steps as plain data; the reference is not part of it."""
        return {
            "tau": self.tau.tolist(),
            "saturated": self.saturated.tolist(),
            "saturated_steps": self.saturated_steps,
            "payload": None if self._payload is None else self._payload.get_state(),
            "carried": self._carried is not None,
            "transfer": self._transfer.tolist(),
            "transfer_steps": self._transfer_steps,
            "compliant": self._compliant,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of ``get_state``."""
        self.tau = np.array(state["tau"])
        self.saturated[:] = state["saturated"]
        self._clipped = bool(self.saturated.any())
        self.saturated_steps = state["saturated_steps"]
        self._transfer = np.array(state["transfer"])
        self._transfer_steps = state["transfer_steps"]
        payload = state["payload"]
        if payload is not None or self._payload is not None:  # creating a model is slow
            self.payload = None if payload is None else Payload.from_state(payload)
        # Not the reference's payload, so that the next step reads it even if it is None.
        self._carried = self._payload if state.get("carried", payload) else None
        self._fault = self._compliant = False
        self._substitute = None
        if state["compliant"]:
            self._become_compliant()

    def _on_model_change(self) -> None:
        """Update data derived from the model; a hook for subclasses."""

    def _on_saturation(self) -> None:
        """React to torques clipped in this step; a hook for subclasses with integrals."""


class _InvalidTorque(Exception):
    """Torques that cannot be commanded; the text has the reason, as a predicate."""


def _torque_problem(
    tau: np.ndarray, limit: np.ndarray, names: Sequence[str], *, saturates: bool
) -> str:
    """Return why torques beyond a limit must not be commanded; empty if they can be clipped."""
    finite = np.isfinite(tau)
    if not finite.all():
        joint = int(np.flatnonzero(~finite)[0])
        return f"returned {tau[joint]} for the torque of joint '{names[joint]}'"
    if saturates:
        return ""
    joint = int(np.argmax(np.abs(tau) / limit))
    return (
        f"returned {tau[joint]:.4g} N m for joint '{names[joint]}', whose limit is "
        f"{limit[joint]:g} N m (set saturates = True in a controller whose torques are to be "
        "clipped)"
    )
