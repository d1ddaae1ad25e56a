"""The physics of one compile of a cell's arena."""

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence

import mujoco
import numpy as np
from dm_control import composer, mjcf
from dm_control.mujoco import wrapper

from ..contacts.contact_monitor import ContactMonitor
from ..contacts.contacts import Contacts
from ..contacts.overlap import refuse_overlap
from ..exceptions import PhysicsDiverged
from ..naming import BodyNames, literal_name
from .attachment import Attachment
from .overrides import Overrides
from .state import INTEGRATION, integration_state, set_integration_state

Hook = Callable[[mjcf.Physics, np.random.RandomState], None]


class CompiledPhysics:
    """Model and data, the entities' step hooks, and tables of names and contacts.

    Each compile creates a new one.

    Args:
        arena: The arena.
        attachments: The attached entities, by name.

    Attributes:
        model: The simulated model, overrides included.
        nominal: The compiled model; the same object as ``model`` without overrides.
        free_joints: Addresses in qpos and qvel of freely moving entities, by name.

    Raises:
        ValueError: If the time step is too long for the contacts of a geom.
    """

    def __init__(
        self, model: mujoco.MjModel, arena: composer.Arena, attachments: Mapping[str, Attachment]
    ):
        self.physics = mjcf.Physics.from_model(wrapper.MjModel(model))
        self.physics.legacy_step = False
        self.model = model
        self.nominal = model
        self.data: mujoco.MjData = self.physics.data.ptr
        self.body_names = BodyNames(self.model)
        _check_contact_damping(self.model)
        self.contacts = Contacts(self.model, self.data, self.body_names)
        entities = list(arena.iter_entities())
        self.contact_monitor = ContactMonitor(self.data, self.body_names, entities)
        self.before_substep = _overridden("before_substep", entities)
        self.after_substep = _overridden("after_substep", entities)
        self.free_joints: dict[str, tuple[int, int]] = {}
        for name, attachment in attachments.items():
            if attachment.free:
                joint = self.model.joint(f"{name}/")
                self.free_joints[name] = (int(joint.qposadr[0]), int(joint.dofadr[0]))
        self._step_start = integration_state(self.model, self.data)
        self._step_start_valid = False
        self._trial: mujoco.MjData | None = None  # to repeat a step; creating it costs many steps
        self._warnings = self.data.warning.number

    def reset(self) -> None:
        """Reset to the state after compiling; the model must be unchanged."""
        mujoco.mj_resetData(self.model, self.data)
        self.physics.after_reset()
        self._step_start_valid = False

    def step(
        self,
        n: int,
        random_state: np.random.RandomState,
        then: Sequence[Callable[[], None]] = (),
    ) -> None:
        """Advance by ``n`` steps with the entities' hooks around each.

        Args:
            n: Number of steps.
            random_state: Passed to the hooks.
            then: Called after each step.

        Raises:
            PhysicsDiverged: If MuJoCo warned.
        """
        physics, model, data = self.physics, self.model, self.data
        before, after, mj_step = self.before_substep, self.after_substep, mujoco.mj_step
        warnings, warned = self._warnings, self._warnings.tolist()
        self._step_start_valid = False
        for i in range(1, n + 1):
            for hook in before:
                hook(physics, random_state)
            if i == n:  # for state_before_last_step()
                mujoco.mj_getState(model, data, self._step_start, INTEGRATION)
            mj_step(model, data)
            if warnings.tolist() != warned:
                self._raise_diverged(warned)
            for hook in after:
                hook(physics, random_state)
            for callback in then:
                callback()
        self._step_start_valid = True

    def apply_overrides(self, overrides: Overrides) -> None:
        """Set the simulated model to the compiled model with overrides."""
        if self.nominal is self.model:
            if not overrides:
                return
            self.nominal = copy.copy(self.model)
        overrides.write(self.model, self.nominal)

    def move(self, name: str, attachment: Attachment, max_overlap: float) -> None:
        """Set the pose of a freely moving entity, at rest.

        Raises:
            OverlapError: If it would penetrate others deeper than ``max_overlap`` [m].
        """
        model, data = self.model, self.data
        qpos, dof = self.free_joints[name]
        pose = (*attachment.position, *attachment.quat_wxyz)
        trial = mujoco.MjData(model)
        mujoco.mj_copyData(trial, model, data)
        trial.qpos[qpos : qpos + 7] = pose
        mujoco.mj_fwdPosition(model, trial)
        refuse_overlap(model, trial, self.body_names, name, max_overlap, "moved")
        data.qpos[qpos : qpos + 7] = pose
        for field in (data.qvel, data.qacc, data.qacc_warmstart):
            field[dof : dof + 6] = 0.0
        mujoco.mj_forward(model, data)

    def state_before_last_step(self) -> np.ndarray | None:
        """Return the state at the start of the last step, if repeating it gives the present state.

        After ``mj_step``, contacts, forces and poses are those of the state at its start. Repeating
        the step restores them.
        """  # (nstate,)
        if not self._step_start_valid:
            return None
        if self._trial is None:
            self._trial = mujoco.MjData(self.model)
        trial = self._trial
        mujoco.mj_resetData(self.model, trial)
        mujoco.mj_setState(self.model, trial, self._step_start, INTEGRATION)
        mujoco.mj_step(self.model, trial)
        now = integration_state(self.model, self.data)
        return (
            self._step_start
            if integration_state(self.model, trial).tobytes() == now.tobytes()
            else None
        )

    def restore(self, state: np.ndarray, before: np.ndarray | None) -> None:
        """Set an integration state, with contacts, forces and poses.

        Args:
            state: The state.  # (nstate,)
            before: The result of ``state_before_last_step`` with it.  # (nstate,)

        Raises:
            ValueError: If a state is of a model of another size.
        """
        set_integration_state(self.model, self.data, state)
        self._step_start_valid = before is not None
        if before is not None:
            self._step_start[:] = before
            mujoco.mj_setState(self.model, self.data, before, INTEGRATION)
            mujoco.mj_step(self.model, self.data)
            # On another machine, the repeated step may differ in the last digits.
            mujoco.mj_setState(self.model, self.data, state, INTEGRATION)

    def _raise_diverged(self, warned: list[int]) -> None:
        names = list(mujoco.mjtWarning.__members__)
        more = np.flatnonzero(self._warnings > warned)
        raised = [names[i].removeprefix("mjWARN_") for i in more]
        raise PhysicsDiverged(f"MuJoCo warned at {self.data.time:.3f} s: {', '.join(raised)}")


def _overridden(hook: str, entities: Iterable[composer.Entity]) -> tuple[Hook, ...]:
    """Return the hooks that entities override, in composer's order."""
    idle = getattr(composer.Entity, hook)
    hooks = (getattr(entity, hook) for entity in entities)
    return tuple(h for h in hooks if getattr(h, "__func__", h) is not idle)


def _check_contact_damping(model: mujoco.MjModel) -> None:
    """Reject unstable contacts: MuJoCo does not check a ``solref`` of stiffness and damping.

    A step changes the contact velocity v by ``-b v dt``, where b is the damping over ``dmax``.
    """
    stiffness, damping = model.geom_solref.T
    direct = (stiffness <= 0) & (damping < 0)
    decay = np.where(direct, -damping / model.geom_solimp[:, 1], 0.0) * model.opt.timestep
    if decay.max(initial=0.0) >= 2.0:
        geom = int(decay.argmax())
        name = literal_name(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom) or "")
        most = 2.0 / decay[geom] * model.opt.timestep
        raise ValueError(
            f"the contacts of geom '{name}' (solref {model.geom_solref[geom]}) need a time step "
            f"below {most:.2g} s, got {model.opt.timestep:g} s"
        )
