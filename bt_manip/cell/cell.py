"""The cell: entities in an arena, and their simulation."""

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.exceptions import did_you_mean
from bt_manip.spatial import pose as make_pose

from .arena import Arena
from .contacts.contact_monitor import ContactMonitor
from .contacts.contacts import ContactEvent, ContactEventDetector, Contacts
from .exceptions import CellError, OverlapError
from .naming import unique_name
from .objects.cell_object import as_object
from .physics.arena_model import ArenaModel, InitialOverrides
from .physics.attachment import Attachment, Factory
from .physics.compiled_physics import CompiledPhysics
from .physics.overrides import nominal_value
from .physics.placement_search import FREE_OVERLAP
from .physics.state import integration_state
from .png import png
from .region import Region
from .rendering import render


class Cell:
    """An arena with entities that are added and removed while the physics runs.

    Entities use composer's hooks: ``after_compile`` is called for all entities after each compile,
    ``initialize_episode`` once for each new entity, ``before_substep`` and ``after_substep`` around
    each step, in the order of ``composer.Environment``.

    Args:
        arena: The arena; default: the project's own.
        timestep: Step of the physics [s].
        random_state: Passed to composer's hooks; default: seed 0.
    """

    def __init__(
        self,
        arena: composer.Arena | None = None,
        timestep: float = 1e-3,
        random_state: np.random.RandomState | None = None,
    ):
        arena = arena if arena is not None else Arena(timestep=timestep)
        arena.mjcf_model.option.timestep = timestep
        self.random_state = random_state or np.random.RandomState(0)
        self._model = ArenaModel(arena, self.random_state)
        self.before_remove: list[Callable[[str], None]] = []
        """Called with the name of an entity before it is removed."""
        self.contact_changed: list[Callable[[ContactEvent], None]] = []
        """Called after each step for every contact that begins or ends; no cost if empty."""
        self._contact_events: ContactEventDetector | None = None

    def __repr__(self) -> str:
        """Show the time and the names of the entities."""
        return f"Cell({self.time:.3f} s; {', '.join(self.entities) or 'empty'})"

    def _repr_png_(self) -> bytes | None:
        """Show the overview in a notebook; None, so that text is shown, without OpenGL."""
        with contextlib.suppress(CellError):  # no OpenGL, or no such camera
            return png(render(self, width=640, height=400))
        return None

    @property
    def compiles_kept(self) -> int:
        """Number of earlier physics that are cached, to be used again with the same entities.

        Default: 8; each takes as much memory as the present one. Returning to a cached physics
        takes a fraction of the time of a compile and has the same results bit for bit. It requires
        the same poses of fixed entities, but not of free ones.
        """
        return self._model.cache.limit

    @compiles_kept.setter
    def compiles_kept(self, limit: int) -> None:
        self._model.cache.limit = limit

    # Entities

    @property
    def arena(self) -> composer.Arena:
        """Composer's arena with all attached entities."""
        return self._model.arena

    @property
    def generation(self) -> int:
        """Number of compiles; views of the physics are invalid after a change."""
        return self._model.generation

    @property
    def entities(self) -> Mapping[str, composer.Entity]:
        """All added entities, robots included, by name, in order."""
        return MappingProxyType({name: a.entity for name, a in self._model.attachments.items()})

    @property
    def objects(self) -> Mapping[str, composer.Entity]:
        """The entities that have a ``category`` or move freely, by name, in order."""
        things = self._model.attachments.items()
        return MappingProxyType(
            {n: a.entity for n, a in things if a.free or as_object(a.entity).category}
        )

    def find(self, name: str) -> composer.Entity:
        """Return an entity by name.

        Raises:
            CellError: If there is none; the nearest names are offered.
        """
        return self._model.find(name).entity

    def add(
        self,
        entity: composer.Entity,
        pose: pin.SE3 | None = None,
        *,
        name: str | None = None,
        free: bool | None = None,
        overlap: float = 2e-3,
    ) -> str:
        """Add an entity; the state of all others is kept bit for bit.

        Args:
            entity: A composer entity that is not attached.
            pose: Pose of its root in the world; default: the origin.
            name: Its unique name; default: its model's name, with ``_1``, ``_2``, ... appended if
                that is taken.
            free: Whether it moves freely; default: the entity's own ``free``, or fixed.
            overlap: Largest accepted penetration with others [m].

        Returns:
            Its name.

        Raises:
            OverlapError: If the penetration would be deeper; the cell is unchanged.
            CellError: If the name is taken or the model does not compile; the cell is unchanged.
        """
        model_name = entity.mjcf_model.model
        label, attachment = self._prepare(entity, pose or pin.SE3.Identity(), name, free)
        try:
            with self._model.change(f"'{label}' cannot be added"):
                self._model.attach(label, attachment, max_overlap=overlap)
        except CellError:
            self._model.rename(entity, model_name)
            raise
        return label

    def place(
        self,
        entity: composer.Entity,
        region: Region,
        rng: np.random.Generator,
        *,
        name: str | None = None,
        free: bool | None = None,
        attempts: int = 100,
        drop: bool = False,
    ) -> str:
        """Add an entity at a free pose sampled from a region.

        Args:
            entity: A composer entity that is not attached.
            region: Region of its origin.
            rng: Random generator for the poses.
            name: As for ``add``.
            free: As for ``add``.
            attempts: Maximum number of sampled poses.
            drop: Whether it falls from the sampled pose in a copy of the cell in which nothing else
                moves, and is added at its pose at rest.

        Returns:
            Its name.

        Raises:
            CellError: If no pose was free; the message has the reason, and the cell is unchanged.
        """
        T_wo = region.sample(rng)
        if not drop and not self._model.editing:
            with contextlib.suppress(OverlapError):  # usually the first pose is free
                return self.add(entity, T_wo, name=name, free=free, overlap=FREE_OVERLAP)
        label, attachment = self._prepare(entity, T_wo, name, free)
        if drop and not attachment.free:
            raise CellError(f"'{label}' is fixed: only entities that move freely can be dropped")
        with self._model.placement_search(label, attachment) as placement:
            T_wo = placement.search(region, rng, first=T_wo, attempts=attempts, drop=drop)
        return self.add(entity, T_wo, name=name, free=free)

    def remove(self, name: str) -> composer.Entity:
        """Remove an entity; the state of all others is kept bit for bit.

        The callbacks in ``before_remove`` are called first.

        Returns:
            The entity, which can be added again.

        Raises:
            CellError: If there is no such entity; the cell is unchanged.
        """
        entity = self.find(name)
        for callback in tuple(self.before_remove):
            callback(name)
        with self._model.change(f"'{name}' cannot be removed"):
            self._model.detach(name)
            self._model.overrides.remove(name)
        return entity

    def is_reusable(self, entity: composer.Entity) -> bool:
        """Return whether an entity was in this cell before, and was not edited or attached since.

        Adding such an entity costs less than adding a new one.
        """
        return self._model.is_reusable(entity)

    def move(self, name: str, T_we: pin.SE3, *, overlap: float = 2e-3) -> None:
        """Set the pose of an entity, at rest; objects that rest on it do not move with it.

        Moving a fixed entity requires a compile.

        Args:
            name: The entity.
            T_we: Its new pose in the world.
            overlap: Largest accepted penetration with anything that it can collide with [m].

        Raises:
            OverlapError: If it would penetrate something deeper; the cell is unchanged.
            CellError: If there is no such entity; the cell is unchanged.
        """
        attachment = self._model.find(name)
        moved = Attachment.at(attachment.entity, T_we, attachment.free)
        if attachment.free and name in self._physics.free_joints:
            self._physics.move(name, moved, overlap)
            return
        with self._model.change(f"'{name}' cannot be moved"):
            self._model.relocate(name, moved, max_overlap=overlap)

    @contextlib.contextmanager
    def editing(self) -> Iterator[None]:
        """Compile once for all entities added and removed inside; undo all changes on failure.

        Inside, the physics is unchanged. Edits of the MJCF of the arena or of entities are compiled
        too; assign whole values (``geom.size = ...``): writing a number into an array of an
        attached model goes unnoticed.

        Raises:
            CellError: If the changed cell does not compile.
        """
        with self._model.edit():
            yield

    # Overrides

    @property
    def initial_overrides(self) -> InitialOverrides | None:
        """Returns the initial overrides of each new entity; None by default."""
        return self._model.initial_overrides

    @initial_overrides.setter
    def initial_overrides(self, initial_overrides: InitialOverrides | None) -> None:
        self._model.initial_overrides = initial_overrides

    def override(self, element: str, **values: Any) -> None:
        """Override physical properties of an entity, light or camera until it is removed.

        Nothing is compiled. Overrides survive later compiles and are part of snapshots.

        Args:
            element: An entity's name, ``light:NAME``, or ``camera:NAME``.
            values: Values by property; None removes an override. Properties of an entity: ``mass``
                [kg], sliding ``friction`` (of a robot: of its links), ``colour``, ``gain`` (a
                factor for each actuator), and ``joint_friction``, the dry friction of each degree
                of freedom [N m or N]; of a light: ``position`` [m], ``direction``, ``colour`` and
                ``brightness``, a factor; of a camera: ``position`` [m], ``rotation`` about its own
                axes [rad], and ``fovy`` [degrees].

        Raises:
            CellError: If there is no such element or property, or a value is impossible; nothing is
                changed.
        """
        self._model.overrides.put(element, values, self._physics.nominal)
        self._physics.apply_overrides(self._model.overrides)

    @property
    def overrides(self) -> dict[str, dict[str, Any]]:
        """All overrides, by element and property, as plain data."""
        return self._model.overrides.get_state()

    def nominal(self, element: str, name: str) -> Any:
        """Return the value of a physical property without overrides.

        Raises:
            CellError: If there is no such element or property.
        """
        return nominal_value(self._physics.nominal, element, name)

    @property
    def nominal_model(self) -> mujoco.MjModel:
        """MuJoCo's model without overrides, for controllers and behaviours.

        The same object as ``model`` if there are none.
        """
        return self._physics.nominal

    # Simulation

    def step(self, n: int = 1, *, then: Sequence[Callable[[], None]] = ()) -> None:
        """Advance by ``n`` control steps, with the entities' hooks around each step of the physics.

        Args:
            n: Number of steps; one call for many steps is a little faster.
            then: Called after each step.

        Raises:
            PhysicsDiverged: If MuJoCo warns, e.g. of numbers that are not finite.
        """
        if not self.contact_changed:
            self._contact_events = None
            self._physics.step(n, self.random_state, then)
            return
        detector = self._contact_events = self._contact_events or ContactEventDetector(
            self.contacts
        )
        for _ in range(n):
            self._physics.step(1, self.random_state)
            for event in detector.update(self.contacts, self.time):
                for callback in tuple(self.contact_changed):
                    callback(event)
            for step_callback in then:
                step_callback()

    @property
    def physics(self) -> mjcf.Physics:
        """The compiled physics; each compile makes a new one."""
        return self._physics.physics

    @property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's simulated model, overrides included."""
        return self._physics.model

    @property
    def data(self) -> mujoco.MjData:
        """MuJoCo's data."""
        return self._physics.data

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._physics.data.time

    @property
    def dt(self) -> float:
        """Duration of a step [s]."""
        return self._physics.model.opt.timestep

    # Poses and contacts

    def pose(self, name: str) -> pin.SE3:
        """Return the pose of an entity's root in the world, ``T_we``.

        Raises:
            CellError: If there is no such entity.
        """
        attachment = self._model.find(name)
        if not attachment.free or name not in self._physics.free_joints:
            return attachment.pose
        qpos, _ = self._physics.free_joints[name]
        q = self.data.qpos[qpos : qpos + 7]
        return make_pose(q[:3], q[3:])

    def surface_height(self, name: str) -> float:
        """Return the height in the world at which objects are placed on an entity [m].

        Raises:
            CellError: If there is no such entity, or it has no surface.
        """
        height = as_object(self.find(name)).surface_height
        if height is None:
            raise CellError(f"'{name}' has no surface to place objects on")
        return float(self.pose(name).translation[2]) + height

    def velocity(self, name: str) -> np.ndarray:
        """Return the velocity of an entity's root: linear, then angular, both in the world.

        Raises:
            CellError: If there is no such entity.
        """  # (6,) [m/s, rad/s]
        if not self._model.find(name).free or name not in self._physics.free_joints:
            return np.zeros(6)
        _, dof = self._physics.free_joints[name]
        v = self.data.qvel[dof : dof + 6].copy()
        v[3:] = self.pose(name).rotation @ v[3:]  # a free joint's angular part is local
        return v

    def body_id(self, name: str) -> int:
        """Return the id of an entity's root body, or of a body called ``entity/body``.

        Raises:
            CellError: If there is no such entity.
        """
        names = self._physics.body_names
        try:
            return names.body_ids(name)[0]
        except KeyError:
            raise CellError(
                f"no body or entity is called '{name}'{did_you_mean(name, names.names())}"
            ) from None

    def is_free(self, name: str) -> bool:
        """Return whether the cell has a freely moving entity of this name."""
        return name in self._physics.free_joints

    @property
    def contacts(self) -> Contacts:
        """The contacts of the last step."""
        return self._physics.contacts

    @property
    def contact_monitor(self) -> ContactMonitor:
        """Detects unexpected contacts of robots in the last step."""
        return self._physics.contact_monitor

    # State

    def state_bytes(self) -> bytes:
        """Return MuJoCo's integration state as bytes, for digests and comparisons."""
        return integration_state(self.model, self.data).tobytes()

    def snapshot(self) -> dict[str, Any]:
        """Return the complete state of the cell, as plain data.

        It consists of the integration state, the entities with their states if any, overrides, and
        the state of ``random_state``. Robots and controllers have their own ``get_state``.
        """
        before = self._physics.state_before_last_step()
        algorithm, keys, *rest = self.random_state.get_state()
        states = {name: as_object(entity).get_state() for name, entity in self.objects.items()}
        return {
            "entities": [a.describe(name) for name, a in self._model.attachments.items()],
            "altered": self._model.overrides.get_state(),
            "states": {name: state for name, state in states.items() if state is not None},
            "integration": integration_state(self.model, self.data).tolist(),
            "before": None if before is None else before.tolist(),
            "random_state": [algorithm, np.asarray(keys).tolist(), *rest],
        }

    def restore(
        self,
        snapshot: Mapping[str, Any],
        factory: Factory | None = None,
        *,
        time: float | None = None,
    ) -> None:
        """Restore a snapshot, adding and removing entities if needed.

        Entities that match the snapshot at their position in the order are kept.

        Args:
            snapshot: What ``snapshot`` returned.
            factory: Creates the entity of an entry of ``snapshot["entities"]``; required if the
                cell lacks one.
            time: Simulated time afterwards [s]; None: that of the snapshot.

        Raises:
            CellError: If a missing entity cannot be created, or the state does not fit; entities
                may have been added and removed.
        """
        self._model.restore(snapshot["entities"], snapshot["altered"], factory)
        before = snapshot["before"]
        try:
            self._physics.restore(
                np.array(snapshot["integration"], dtype=float),
                None if before is None else np.array(before, dtype=float),
            )
            if time is not None:
                self.data.time = time
        except (TypeError, ValueError) as error:
            raise CellError(f"the snapshot does not fit this cell: {error}") from error
        for name, state in snapshot["states"].items():
            as_object(self.objects[name]).set_state(state)
        self.random_state.set_state(tuple(snapshot["random_state"]))
        self._contact_events = None  # compare the next step with the restored contacts

    # Internal

    def _prepare(
        self, entity: composer.Entity, T_we: pin.SE3, name: str | None, free: bool | None
    ) -> tuple[str, Attachment]:
        """Return the name of a new entity, and whether it moves freely."""
        model_name = entity.mjcf_model.model
        if entity.parent is not None:
            raise CellError(f"'{model_name}' is already attached to a cell or an entity")
        taken = self._model.attachments
        label = name or unique_name(model_name, taken)
        if label in taken:
            free_name = unique_name(label, taken)
            raise CellError(f"there is already a '{label}' in the cell; '{free_name}' is free")
        if "/" in label:
            raise CellError(f"a name cannot contain '/', got '{label}'")
        free = bool(as_object(entity).free) if free is None else free
        return label, Attachment.at(entity, T_we, free)

    @property
    def _physics(self) -> CompiledPhysics:
        return self._model.physics
