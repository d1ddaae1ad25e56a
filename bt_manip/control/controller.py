"""The base of arm controllers."""

import abc
from collections.abc import Mapping
from operator import le
from typing import Any, ClassVar

import numpy as np
from dm_control import composer, mjcf
from numpy import ndarray

from bt_manip.control.exceptions import ControlError, ControllerFault
from bt_manip.control.reference import Hold, Reference
from bt_manip.control.watch import problem_with
from bt_manip.robots import Payload, Robot, RobotModel, reader, writer

FLOAT = np.dtype(np.float64)


class Controller(composer.Entity):
    """Turns a reference into the efforts of a robot's arm, once per step of the physics.

    A controller is attached to its robot (``robot.attach(controller)``), and lives by composer's
    hooks from then on. A new kind of controller writes ``compute``; what it remembers between
    steps goes into ``get_state`` and ``set_state``.

    What ``compute`` gives is looked at before the arm gets it. When it raises, or gives numbers
    that are not finite, too many or too few, or beyond the effort limits, a plain PD takes its
    place at once and a `ControllerFault` leaves the step: whoever steps the cell can still bring
    the arm to rest.
    """

    kind: ClassVar[str] = "controller"

    cuts_to_limits: ClassVar[bool] = False
    """Whether efforts beyond the limits are cut and counted; they are a fault where not."""

    def _build(self, robot: Robot) -> None:
        """Prepare to control a robot's arm; subclasses add their gains."""
        self._mjcf_root = mjcf.RootElement(model=self.kind)
        self._robot = robot
        self._limit = np.array(robot.limits.effort)
        self._bounds = self._limit.tolist()
        self._shape = self._limit.shape
        self._fault = False
        self._bare: RobotModel | None = None
        self._model: RobotModel | None = None
        self._payload: Payload | None = None
        self._reference: Reference | None = None
        self._carries = False
        self._dt = 0.0
        self._cut = False
        self.tau = np.zeros_like(self._limit)
        """Efforts of the last step, inside the limits [N m]."""  # (nv,)
        self.saturated = np.zeros(self._limit.shape, dtype=bool)
        """Joints whose limit cut the effort of the last step."""  # (nv,)
        self.saturated_steps = 0
        """Steps so far in which any joint's limit cut its effort."""

    @abc.abstractmethod
    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Give the efforts for one step, limits not yet applied [N m]."""  # (nv,)

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """An empty model: what composer attaches."""
        return self._mjcf_root

    @property
    def robot(self) -> Robot:
        """The robot whose arm this controls."""
        return self._robot

    @property
    def model(self) -> RobotModel:
        """The model that this computes with; it carries the payload."""
        if self._model is None:
            # Always made from the bare one: the same payload gives the same bits, whatever was
            # carried before.
            self._bare = self._bare or self._robot.make_model()
            self._model = self._bare.with_payload(self._payload)
            self._model_changed()
        return self._model

    @property
    def payload(self) -> Payload | None:
        """What the arm holds, and its efforts include."""
        return self._payload

    @payload.setter
    def payload(self, payload: Payload | None) -> None:
        self._payload = payload
        self._model = None

    @property
    def reference(self) -> Reference:
        """What the arm follows; until one is given, the configuration where it stood.

        A reference that has a ``payload`` says what the arm carries, too.

        Raises:
            ControlError: When a reference is set whose arrays are not those of this arm.
        """
        if self._reference is None:
            self._reference = Hold(self._robot.q)
        return self._reference

    @reference.setter
    def reference(self, reference: Reference | None) -> None:
        if reference is not None:
            for name in ("q", "v", "a"):
                x = getattr(reference, name)
                if x.shape != self._limit.shape or x.dtype != np.float64:
                    raise ControlError(
                        f"a reference's {name} is {len(self._limit)} numbers of type float64, "
                        f"one a joint, got {x.dtype} {x.shape}"
                    )
        self._reference = reference
        self._carries = hasattr(reference, "payload")

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model (composer's hook)."""
        model, data = physics.model.ptr, physics.data.ptr
        robot = self._robot
        self._data = data
        self._dt = float(model.opt.timestep)
        # Bound once: looking into the data takes longer than computing with what is there.
        self._q, self._v = reader(data.qpos, robot.qpos_adr), reader(data.qvel, robot.dof_adr)
        self._drive = writer(data.ctrl, robot.ctrl_adr)

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Forget the last episode (composer's hook)."""
        self.reset()
        if isinstance(self._reference, Hold):
            self._reference = None

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the efforts for the step that begins now (composer's hook)."""
        reference = self._reference or self.reference
        if self._carries and reference.payload is not self._payload:  # type: ignore[attr-defined]
            self.payload = reference.payload  # type: ignore[attr-defined]
        try:
            tau = self.compute(self._q(), self._v(), reference.q, reference.v, reference.a)
        except (Exception, SystemExit) as error:
            text = " ".join(str(error).split())
            raise self._take_over(f"raised {type(error).__name__}: {text}") from error
        if type(tau) is not ndarray or tau.dtype is not FLOAT or tau.shape != self._shape:
            tau = self._as_efforts(tau)
        # One by one: for so few NumPy takes longer to begin. What is no number is not inside.
        if not all(map(le, map(abs, tau.tolist()), self._bounds)):
            tau = self._cut_to_limits(tau)
        elif self._cut:
            self._cut = self.saturated[:] = False
        self.tau = tau
        self._drive(tau)

    def _as_efforts(self, tau: Any) -> np.ndarray:
        """Take an array of another type of numbers, and nothing else."""
        shaped = isinstance(tau, ndarray) and tau.shape == self._shape and tau.dtype.kind in "fiu"
        if not shaped:
            found = f"a value of type {type(tau).__name__}"
            if isinstance(tau, ndarray):
                found = f"{tau.dtype} of shape {tau.shape}"
            raise self._take_over(
                f"gave {found} for its efforts, which are an array of {self._shape[0]} numbers, "
                f"one a joint"
            )
        return tau.astype(FLOAT)

    def _take_over(self, problem: str) -> ControllerFault:
        """Let a plain PD drive the arm from here on; give what there is to raise."""
        from bt_manip.control.gravity_compensated_pd import GravityCompensatedPD

        self._fault = True
        stand_in = GravityCompensatedPD(self._robot)
        stand_in.payload = self._payload
        self.compute = stand_in.compute  # type: ignore[method-assign]
        return ControllerFault(self.kind, type(self).__module__, problem, self._data.time)

    def _cut_to_limits(self, tau: np.ndarray) -> np.ndarray:
        limited = np.maximum(np.minimum(tau, self._limit), -self._limit)
        np.not_equal(limited, tau, out=self.saturated)
        self._cut = bool(self.saturated.any())
        if self._cut:
            problem = problem_with(
                tau,
                self._limit,
                self._robot.description.arm_joints,
                cuts=self.cuts_to_limits or self._fault,
            )
            if problem:
                raise self._take_over(problem)
            self.saturated_steps += 1
            self._were_cut()
        return limited

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Let the reference go on with the time (composer's hook)."""
        (self._reference or self.reference).advance(self._dt)

    def reset(self) -> None:
        """Forget what was remembered between steps."""
        if self._fault:
            self._fault = False
            del self.compute  # the stand-in's
        self.tau = np.zeros_like(self._limit)
        self.saturated[:] = self._cut = False
        self.saturated_steps = 0

    def get_state(self) -> dict[str, Any]:
        """Give what is remembered between steps as plain data; the reference keeps its own."""
        return {
            "tau": self.tau.tolist(),
            "saturated": self.saturated.tolist(),
            "saturated_steps": self.saturated_steps,
            "payload": None if self._payload is None else self._payload.get_state(),
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take back what ``get_state`` gave."""
        self.tau = np.array(state["tau"])
        self.saturated[:] = state["saturated"]
        self._cut = bool(self.saturated.any())
        self.saturated_steps = state["saturated_steps"]
        payload = state["payload"]
        if payload is not None or self._payload is not None:  # a new model takes a while
            self.payload = None if payload is None else Payload.from_state(payload)

    def _model_changed(self) -> None:
        """Take up a new model; for subclasses that keep parts of it."""

    def _were_cut(self) -> None:
        """Take note that limits have just cut efforts; for subclasses that integrate."""
