"""The cell: an arena whose entities come and go while the physics runs."""

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.cell.arena import Arena
from bt_manip.cell.assembly import Assembly
from bt_manip.cell.compiled import Compiled
from bt_manip.cell.contact_events import ContactChanges, ContactEvent
from bt_manip.cell.contacts import Contacts
from bt_manip.cell.exceptions import CellError, OverlapError
from bt_manip.cell.inventory import Inventory
from bt_manip.cell.naming import unique_name
from bt_manip.cell.placement import Factory, Placement
from bt_manip.cell.placing import CLEAR, find_place
from bt_manip.cell.region import Region
from bt_manip.cell.state import integration_state
from bt_manip.cell.touch import TouchMonitor
from bt_manip.exceptions import did_you_mean
from bt_manip.spatial import pose as make_pose


class Cell:
    """Owns the arena and its compiled physics, and is the one loop that steps it.

    Entities live by composer's hooks: ``after_compile`` runs for all of them after every change,
    ``initialize_episode`` once for each that is new, ``before_substep`` and ``after_substep``
    around each step, in the order in which ``composer.Environment`` runs them.
    """

    def __init__(
        self,
        arena: composer.Arena | None = None,
        timestep: float = 1e-3,
        random_state: np.random.RandomState | None = None,
    ):
        """Make a cell with nothing in it, or with what the arena already holds.

        Args:
            arena: The room; default: the project's own.
            timestep: Step of the physics [s].
            random_state: What composer's hooks get to draw from; default: seed 0.
        """
        arena = arena if arena is not None else Arena(timestep=timestep)
        arena.mjcf_model.option.timestep = timestep
        self.random_state = random_state or np.random.RandomState(0)
        self._assembly = Assembly(arena, self.random_state)
        self.before_remove: list[Callable[[str], None]] = []
        """Called with the name of an entity that is about to be taken out."""
        self.contact_changed: list[Callable[[ContactEvent], None]] = []
        """Called after each step with every contact that begins or ends; costs nothing if empty."""
        self._changes: ContactChanges | None = None

    # What is in it

    @property
    def arena(self) -> composer.Arena:
        """The room and everything in it, as composer has it."""
        return self._inventory.arena

    @property
    def generation(self) -> int:
        """Number of compiles; whoever keeps views of the data looks here whether they are old."""
        return self._assembly.generation

    @property
    def entities(self) -> Mapping[str, composer.Entity]:
        """Everything that was added, robots too, by name, in order."""
        return MappingProxyType({name: p.entity for name, p in self._inventory.placed.items()})

    @property
    def objects(self) -> Mapping[str, composer.Entity]:
        """The things to work with or around: entities with a ``category``, and free ones."""
        things = self._inventory.placed.items()
        return MappingProxyType(
            {n: p.entity for n, p in things if p.free or hasattr(p.entity, "category")}
        )

    def find(self, name: str) -> composer.Entity:
        """Give the entity of a name.

        Raises:
            CellError: When there is none; the nearest names are offered.
        """
        return self._inventory.find(name).entity

    def add(
        self,
        entity: composer.Entity,
        pose: pin.SE3 | None = None,
        *,
        name: str | None = None,
        free: bool | None = None,
        overlap: float = 2e-3,
    ) -> str:
        """Put an entity into the cell while everything else keeps its exact state.

        Args:
            entity: A composer entity that stands nowhere else.
            pose: Pose of its root in the world; default: the origin.
            name: Name to give it, with ``_1``, ``_2``, ... where taken; default: its model's name.
            free: Whether it moves freely; default: the entity's own ``free``, or fixed.
            overlap: How deep it may be inside something else that it can touch [m].

        Returns:
            The name it got.

        Raises:
            OverlapError: When it would be deeper inside something else; the cell is unchanged.
            CellError: When the model does not compile; the cell is unchanged.
        """
        model_name = entity.mjcf_model.model
        label, placement = self._prepare(entity, pose or pin.SE3.Identity(), name, free)
        try:
            with self._assembly.change(f"'{label}' cannot be added"):
                self._inventory.attach(label, placement)
                self._inventory.accepted[label] = overlap
        except CellError:
            entity.mjcf_model.model = model_name
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
        """Put an entity at a free pose that is drawn from a region.

        Args:
            entity: A composer entity that stands nowhere else.
            region: Where its origin may come to be.
            rng: What poses are drawn from.
            name: As for ``add``.
            free: As for ``add``.
            attempts: How many poses are tried.
            drop: Whether it falls from there in a copy of the cell, all else standing still, and
                is put where it comes to rest.

        Returns:
            The name it got.

        Raises:
            CellError: When no free place was found, with the reason; the cell is unchanged.
        """
        T_wo = region.sample(rng)
        if not drop and not self._assembly.editing:
            with contextlib.suppress(OverlapError):  # most often there is room at once
                return self.add(entity, T_wo, name=name, free=free, overlap=CLEAR)
        label, placement = self._prepare(entity, T_wo, name, free)
        if drop and not placement.free:
            raise CellError(f"'{label}' is fixed: only what moves freely can be dropped")
        with self._assembly.probe(label, placement) as probe:
            T_wo = find_place(probe, region, rng, first=T_wo, attempts=attempts, drop=drop)
        return self.add(entity, T_wo, name=name, free=free)

    def remove(self, name: str) -> composer.Entity:
        """Take an entity out while everything else keeps its exact state.

        Whoever listens in ``before_remove`` is told first, while the physics is still whole.

        Returns:
            The entity, which can be added again.

        Raises:
            CellError: When there is none of that name; the cell is unchanged.
        """
        entity = self.find(name)
        for listener in tuple(self.before_remove):
            listener(name)
        with self._assembly.change(f"'{name}' cannot be removed"):
            self._inventory.detach(name)
        return entity

    @contextlib.contextmanager
    def editing(self) -> Iterator[None]:
        """Compile once for all that is added and removed inside, or leave the cell as it was.

        Inside, the physics is still the old one. What is edited by hand in the MJCF of the arena
        or of what stands in it is compiled too; assign whole values (``geom.size = ...``), because
        a number that is written into an array of an attached model goes unnoticed.

        Raises:
            CellError: When the changed cell does not compile.
        """
        with self._assembly.edit():
            yield

    # How it moves

    def step(self, n: int = 1, *, then: Sequence[Callable[[], None]] = ()) -> None:
        """Make ``n`` control steps: the entities' hooks around each step of the physics.

        Args:
            n: How many; many at once cost a little less than one by one.
            then: Called after each.

        Raises:
            PhysicsDiverged: When MuJoCo warns, as it does of numbers that are not finite.
        """
        if not self.contact_changed:
            self._changes = None
            self._compiled.step(n, self.random_state, then)
            return
        changes = self._changes = self._changes or ContactChanges(self.contacts)
        for _ in range(n):
            self._compiled.step(1, self.random_state)
            for event in changes.look(self.contacts, self.time):
                for listener in tuple(self.contact_changed):
                    listener(event)
            for look in then:
                look()

    @property
    def physics(self) -> mjcf.Physics:
        """The compiled physics; a change of the cell makes a new one."""
        return self._compiled.physics

    @property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's own model."""
        return self._compiled.model

    @property
    def data(self) -> mujoco.MjData:
        """MuJoCo's own data."""
        return self._compiled.data

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._compiled.data.time

    @property
    def dt(self) -> float:
        """Duration of a step [s]."""
        return self._compiled.model.opt.timestep

    # Where things are, and what touches what

    def pose(self, name: str) -> pin.SE3:
        """Give the pose of an entity's root in the world, ``T_we``.

        Raises:
            CellError: When there is none of that name.
        """
        placement = self._inventory.find(name)
        if not placement.free or name not in self._compiled.free_joints:
            return placement.pose
        qpos, _ = self._compiled.free_joints[name]
        q = self.data.qpos[qpos : qpos + 7]
        return make_pose(q[:3], q[3:])

    def velocity(self, name: str) -> np.ndarray:
        """Give the velocity of an entity's root: linear, then angular, both in the world.

        Raises:
            CellError: When there is none of that name.
        """  # (6,) [m/s, rad/s]
        if not self._inventory.find(name).free or name not in self._compiled.free_joints:
            return np.zeros(6)
        _, dof = self._compiled.free_joints[name]
        v = self.data.qvel[dof : dof + 6].copy()
        v[3:] = self.pose(name).rotation @ v[3:]  # a free joint's angular part is local
        return v

    def body_id(self, name: str) -> int:
        """Give the id of the root body of an entity, or of a body called ``entity/body``.

        Raises:
            CellError: When nothing is called so.
        """
        labels = self._compiled.labels
        try:
            return labels.body_ids(name)[0]
        except KeyError:
            raise CellError(
                f"no body or entity is called '{name}'{did_you_mean(name, labels.names())}"
            ) from None

    @property
    def contacts(self) -> Contacts:
        """The contacts of the last step."""
        return self._compiled.contacts

    @property
    def touch(self) -> TouchMonitor:
        """The judge of each step's contacts."""
        return self._compiled.touch

    # Its state

    def state_bytes(self) -> bytes:
        """Give MuJoCo's integration state as bytes, for digests and comparisons."""
        return integration_state(self.model, self.data).tobytes()

    def get_state(self) -> dict[str, Any]:
        """Give all that the cell's future follows from, as plain data.

        The integration state, what stands in the cell with the states of those objects that have
        one, and what composer's hooks draw from. Robots and controllers give theirs by themselves.
        """
        before = self._compiled.before_last_step()
        algorithm, keys, *rest = self.random_state.get_state()
        return {
            "entities": [p.describe(name) for name, p in self._inventory.placed.items()],
            "states": {
                n: e.get_state() for n, e in self.objects.items() if hasattr(e, "get_state")
            },
            "integration": integration_state(self.model, self.data).tolist(),
            "before": None if before is None else before.tolist(),
            "random_state": [algorithm, np.asarray(keys).tolist(), *rest],
        }

    def set_state(self, state: Mapping[str, Any], factory: Factory | None = None) -> None:
        """Put a state back, taking out and putting in entities where that is needed.

        What already stands at its place in the order, alike in name and kind, stays what it is.

        Args:
            state: What ``get_state`` gave.
            factory: Makes the entity of an entry of ``state["entities"]``; needed where the cell
                lacks one.

        Raises:
            CellError: When an entity is missing and cannot be made, or the numbers do not fit;
                the cell is unchanged but for entities that came and went.
        """
        entries = state["entities"]
        if not self._inventory.is_as(entries):
            with self.editing():
                self._inventory.become(entries, factory)
        before = state["before"]
        try:
            self._compiled.restore(
                np.array(state["integration"]), None if before is None else np.array(before)
            )
        except ValueError as error:
            raise CellError(f"the state does not fit this cell: {error}") from error
        for name, kept in state["states"].items():
            self.objects[name].set_state(kept)
        self.random_state.set_state(tuple(state["random_state"]))

    # Inside

    def _prepare(
        self, entity: composer.Entity, T_we: pin.SE3, name: str | None, free: bool | None
    ) -> tuple[str, Placement]:
        """Find the name of a new entity, and how it is placed."""
        model_name = entity.mjcf_model.model
        if entity.parent is not None:
            raise CellError(f"'{model_name}' already stands in a cell or on an entity")
        label = unique_name(name or model_name, self._inventory.placed)
        if "/" in label:
            raise CellError(f"a name cannot contain '/', got '{label}'")
        if free is None:
            free = bool(getattr(entity, "free", False))
        return label, Placement.of(entity, T_we, free)

    @property
    def _inventory(self) -> Inventory:
        return self._assembly.inventory

    @property
    def _compiled(self) -> Compiled:
        return self._assembly.compiled
