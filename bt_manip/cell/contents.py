"""What stands in a cell: how it comes, goes, moves and is altered."""

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import composer

from bt_manip.cell.arena import Arena
from bt_manip.cell.assembly import Assembly
from bt_manip.cell.exceptions import CellError, OverlapError
from bt_manip.cell.inventory import Inventory
from bt_manip.cell.naming import unique_name
from bt_manip.cell.physics.attachment import Attachment, Factory
from bt_manip.cell.physics.compiled_physics import CompiledPhysics
from bt_manip.cell.physics.overrides import Values
from bt_manip.cell.placing import CLEAR, find_place
from bt_manip.cell.region import Region


class Contents:
    """The entities of an arena, which come and go while all others keep their exact state."""

    def __init__(
        self,
        arena: composer.Arena | None = None,
        timestep: float = 1e-3,
        random_state: np.random.RandomState | None = None,
    ):
        """Begin with nothing, or with what the arena already holds.

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

    @property
    def compiles_kept(self) -> int:
        """How many earlier physics are kept, for when the same things stand here again.

        None at first; each takes as much memory as the one in use. Going back to one takes a
        fraction of the time of a compile, and is the same to the last bit.
        """
        return self._assembly.cache.limit

    @compiles_kept.setter
    def compiles_kept(self, limit: int) -> None:
        self._assembly.cache.limit = self._inventory.spares.limit = limit

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
            name: Name to give it, which must be free; default: its model's name, with ``_1``,
                ``_2``, ... where that is taken.
            free: Whether it moves freely; default: the entity's own ``free``, or fixed.
            overlap: How deep it may be inside something else that it can touch [m].

        Returns:
            The name it got.

        Raises:
            OverlapError: When it would be deeper inside something else; the cell is unchanged.
            CellError: When the name is taken or the model does not compile; the cell is unchanged.
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
            self._assembly.overrides.forget(name)
        return entity

    def move(self, name: str, T_we: pin.SE3, *, overlap: float = 2e-3) -> None:
        """Put an entity that is in the cell somewhere else, at rest.

        What stands on it stays where it is. What is fixed is compiled anew.

        Args:
            name: The entity.
            T_we: Its new pose in the world.
            overlap: How deep it may be inside something else that it can touch [m].

        Raises:
            OverlapError: When it would be deeper inside something else; the cell is unchanged.
            CellError: When there is none of that name; the cell is unchanged.
        """
        placement = self._inventory.find(name)
        moved = Attachment.of(placement.entity, T_we, placement.free)
        if placement.free and name in self._compiled.free_joints:
            self._compiled.put(name, moved, overlap)
            return
        with self._assembly.change(f"'{name}' cannot be moved"):
            self._inventory.relocate(name, moved)
            self._inventory.accepted[name] = overlap

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

    # Inside

    def _become(
        self,
        entries: Sequence[Mapping[str, Any]],
        altered: Mapping[str, Values],
        factory: Factory | None,
    ) -> None:
        """Let exactly what was described stand here, altered like this."""
        if not self._inventory.is_as(entries):
            with self._assembly.edit(varied=False):
                self._inventory.become(entries, factory)
        self._assembly.overrides.set_state(altered)
        self._compiled.apply_overrides(self._assembly.overrides)

    def _prepare(
        self, entity: composer.Entity, T_we: pin.SE3, name: str | None, free: bool | None
    ) -> tuple[str, Attachment]:
        """Find the name of a new entity, and how it is placed."""
        model_name = entity.mjcf_model.model
        if entity.parent is not None:
            raise CellError(f"'{model_name}' already stands in a cell or on an entity")
        placed = self._inventory.placed
        label = name or unique_name(model_name, placed)
        if label in placed:
            free_name = unique_name(label, placed)
            raise CellError(f"there is already a '{label}' in the cell; '{free_name}' is free")
        if "/" in label:
            raise CellError(f"a name cannot contain '/', got '{label}'")
        if free is None:
            free = bool(getattr(entity, "free", False))
        return label, Attachment.of(entity, T_we, free)

    @property
    def _inventory(self) -> Inventory:
        return self._assembly.inventory

    @property
    def _compiled(self) -> CompiledPhysics:
        return self._assembly.compiled
