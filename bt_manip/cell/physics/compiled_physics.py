"""All that follows from one compile of a cell's arena."""

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence

import mujoco
import numpy as np
from dm_control import composer, mjcf
from dm_control.mujoco import wrapper

from bt_manip.cell.contacts.contact_monitor import ContactMonitor
from bt_manip.cell.contacts.contacts import Contacts
from bt_manip.cell.contacts.overlap import refuse_overlap
from bt_manip.cell.exceptions import PhysicsDiverged
from bt_manip.cell.naming import BodyNames, body_name
from bt_manip.cell.physics.attachment import Attachment
from bt_manip.cell.physics.overrides import Overrides
from bt_manip.cell.physics.state import INTEGRATION, integration_state, set_integration_state

Hook = Callable[[mjcf.Physics, np.random.RandomState], None]


class CompiledPhysics:
    """A physics, the hooks that its steps run, and the tables that questions are answered from.

    A changed cell gets a new one; nothing in here outlives its physics.
    """

    def __init__(
        self, model: mujoco.MjModel, arena: composer.Arena, placed: Mapping[str, Attachment]
    ):
        """Make a physics of a model.

        Args:
            model: What the arena was compiled to.
            arena: The arena.
            placed: What stands in it.

        Raises:
            ValueError: When the time step is too long for the contacts of a geom.
        """
        self.physics = mjcf.Physics.from_model(wrapper.MjModel(model))
        self.physics.legacy_step = False
        self.model = model
        self.nominal = model
        """As it was compiled; a model of its own as soon as the other one is altered."""
        self.data: mujoco.MjData = self.physics.data.ptr
        self.labels = BodyNames(self.model)
        _check_contact_damping(self.model)
        self.contacts = Contacts(self.model, self.data, self.labels)
        entities = list(arena.iter_entities())
        self.contact_monitor = ContactMonitor(self.data, self.labels, _fingers(entities))
        self.before_substep = _overridden("before_substep", entities)
        self.after_substep = _overridden("after_substep", entities)
        self.free_joints: dict[str, tuple[int, int]] = {}
        for name, placement in placed.items():
            if placement.free:
                joint = self.model.joint(f"{name}/")
                self.free_joints[name] = (int(joint.qposadr[0]), int(joint.dofadr[0]))
        self._kept = integration_state(self.model, self.data)
        self._remembers = False
        self._warnings = self.data.warning.number
        self._warned = self._warnings.tobytes()

    def renew(self) -> None:
        """Be as just made of the model, which nobody has changed."""
        mujoco.mj_resetData(self.model, self.data)
        self.physics.after_reset()
        self._remembers = False
        self._warned = self._warnings.tobytes()

    def step(
        self,
        n: int,
        random_state: np.random.RandomState,
        then: Sequence[Callable[[], None]] = (),
    ) -> None:
        """Make ``n`` steps with the entities' hooks around each.

        Args:
            n: How many.
            random_state: What the hooks draw from.
            then: Called after each.

        Raises:
            PhysicsDiverged: When MuJoCo warned meanwhile.
        """
        physics, model, data = self.physics, self.model, self.data
        before, after, mj_step = self.before_substep, self.after_substep, mujoco.mj_step
        warnings, warned = self._warnings, self._warned
        self._remembers = False
        for i in range(1, n + 1):
            for hook in before:
                hook(physics, random_state)
            if i == n:  # what the last one is made from, for a state that is taken afterwards
                mujoco.mj_getState(model, data, self._kept, INTEGRATION)
            mj_step(model, data)
            if warnings.tobytes() != warned:
                self._raise_diverged()
            for hook in after:
                hook(physics, random_state)
            for look in then:
                look()
        self._remembers = True

    def apply_overrides(self, alterations: Overrides) -> None:
        """Let the model that is simulated differ in exactly these values from the compiled one."""
        if self.nominal is self.model:
            if not alterations:
                return
            self.nominal = copy.copy(self.model)
        alterations.write(self.model, self.nominal)

    def put(self, name: str, placement: Attachment, accepted: float) -> None:
        """Put something that moves freely somewhere, at rest.

        Raises:
            OverlapError: When it would be deeper inside something else than is accepted [m].
        """
        model, data = self.model, self.data
        qpos, dof = self.free_joints[name]
        there = (*placement.position, *placement.quat_wxyz)
        trial = mujoco.MjData(model)
        mujoco.mj_copyData(trial, model, data)
        trial.qpos[qpos : qpos + 7] = there
        mujoco.mj_fwdPosition(model, trial)
        refuse_overlap(model, trial, self.labels, name, accepted, "moved")
        data.qpos[qpos : qpos + 7] = there
        for field in (data.qvel, data.qacc, data.qacc_warmstart):
            field[dof : dof + 6] = 0.0
        mujoco.mj_kinematics(model, data)

    def before_last_step(self) -> np.ndarray | None:
        """Give the state that the last step was made from, if the state of now follows from it.

        A step leaves contacts, forces and poses of where it came from. Whoever wants them back
        makes it once more.
        """  # (nstate,)
        if not self._remembers:
            return None
        trial = mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, trial, self._kept, INTEGRATION)
        mujoco.mj_step(self.model, trial)
        now = integration_state(self.model, self.data)
        return (
            self._kept if integration_state(self.model, trial).tobytes() == now.tobytes() else None
        )

    def restore(self, state: np.ndarray, before: np.ndarray | None) -> None:
        """Put an integration state back, with contacts, forces and poses.

        Args:
            state: The state.  # (nstate,)
            before: What ``before_last_step`` gave with it.  # (nstate,)

        Raises:
            ValueError: When a state was taken from a model of another size.
        """
        set_integration_state(self.model, self.data, state)
        self._remembers = before is not None
        if before is not None:
            self._kept[:] = before
            mujoco.mj_setState(self.model, self.data, before, INTEGRATION)
            mujoco.mj_step(self.model, self.data)
            # What another machine's last digits may have changed is put right.
            mujoco.mj_setState(self.model, self.data, state, INTEGRATION)

    def _raise_diverged(self) -> None:
        names = list(mujoco.mjtWarning.__members__)
        before = np.frombuffer(self._warned, self._warnings.dtype)
        raised = [names[i].removeprefix("mjWARN_") for i in np.flatnonzero(self._warnings > before)]
        self._warned = self._warnings.tobytes()
        raise PhysicsDiverged(f"MuJoCo warned at {self.data.time:.3f} s: {', '.join(raised)}")


def _overridden(hook: str, entities: Iterable[composer.Entity]) -> tuple[Hook, ...]:
    """Collect the hooks that do something, in composer's order."""
    idle = getattr(composer.Entity, hook)
    hooks = (getattr(entity, hook) for entity in entities)
    return tuple(h for h in hooks if getattr(h, "__func__", h) is not idle)


def _fingers(entities: Iterable[composer.Entity]) -> list[str]:
    """Name the bodies of all robots that may touch things."""
    return [
        body_name(body.full_identifier)
        for entity in entities
        for body in getattr(entity, "finger_bodies", ())
    ]


def _check_contact_damping(model: mujoco.MjModel) -> None:
    """Refuse contacts that would swing up: ``solref`` as stiffness and damping is not checked.

    A step changes the contact velocity v by ``-b v dt``, with b the damping over ``dmax``.
    """
    stiffness, damping = model.geom_solref.T
    direct = (stiffness <= 0) & (damping < 0)
    decay = np.where(direct, -damping / model.geom_solimp[:, 1], 0.0) * model.opt.timestep
    if decay.max(initial=0.0) >= 2.0:
        geom = int(decay.argmax())
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom)
        most = 2.0 / decay[geom] * model.opt.timestep
        raise ValueError(
            f"the contacts of geom '{name}' (solref {model.geom_solref[geom]}) need a time step "
            f"below {most:.2g} s, got {model.opt.timestep:g} s"
        )
