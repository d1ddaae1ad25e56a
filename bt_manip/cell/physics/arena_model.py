"""The arena's MJCF with the attached entities, and the physics compiled from it."""

import contextlib
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from dm_control import composer, mjcf

from bt_manip.exceptions import did_you_mean

from ..contacts.overlap import refuse_overlap
from ..exceptions import CellError
from ..naming import name_elements
from ..objects.cell_object import as_object
from .attachment import Attachment, Factory
from .compiled_physics import CompiledPhysics
from .edit_tracker import EditTracker
from .mjcf_writer import MjcfWriter
from .overrides import Overrides, Values
from .physics_cache import CacheKey, PhysicsCache
from .placement_search import PlacementSearch
from .state import carry_state

InitialOverrides = Callable[[str, composer.Entity, mujoco.MjModel], Values]
"""Returns the initial overrides of a new entity, given its name and the compiled model."""


class ArenaModel:
    """The entities attached to an arena and the physics compiled from it.

    Both change together inside ``change`` or ``edit``; a change that does not compile is undone.

    Args:
        random_state: Passed to composer's hooks.

    Attributes:
        arena: The arena.
        attachments: The attached entities by name, in order.
        physics: The compiled physics.
        generation: Number of compiles.
        editing: Whether several changes are in progress, to be compiled together.
        overrides: Values of the compiled model that differ from the MJCF.
        initial_overrides: Called for each new entity; None by default.
        cache: Earlier physics, used again when the same entities are attached.
    """

    def __init__(self, arena: composer.Arena, random_state: np.random.RandomState):
        self.arena = arena
        self.attachments: dict[str, Attachment] = {}
        self.generation = 0
        self.editing = False
        self.overrides = Overrides()
        self.initial_overrides: InitialOverrides | None = None
        self.cache = PhysicsCache()
        self._random_state = random_state
        self._tracker = EditTracker(arena.mjcf_model)
        self._writer = MjcfWriter(arena.mjcf_model, self._tracker)
        # Since the last compile:
        self._uninitialised: list[composer.Entity] = list(arena.iter_entities())
        self._new: dict[str, composer.Entity] = {}
        self._max_overlap: dict[str, float] = {}  # [m]
        self.physics = self._compile(None)
        self._uninitialised.clear()

    # Entities

    def find(self, name: str) -> Attachment:
        """Return the attachment of an entity by name.

        Raises:
            CellError: If there is none; the nearest names are offered.
        """
        try:
            return self.attachments[name]
        except KeyError:
            near = did_you_mean(name, self.attachments)
            raise CellError(f"there is no '{name}' in the cell{near}") from None

    def attach(
        self,
        name: str,
        attachment: Attachment,
        *,
        new: bool = True,
        max_overlap: float | None = None,
    ) -> None:
        """Attach an entity under a name.

        Args:
            name: Its name.
            attachment: The entity and its pose.
            new: Whether it is initialised, instead of keeping its state.
            max_overlap: Largest accepted penetration, checked after the compile [m]; None: any.
        """
        model = attachment.entity.mjcf_model
        is_named = self._tracker.is_unedited(model)
        with self._tracker.attaching(model):
            model.model = name
            if not is_named:
                for part in attachment.entity.iter_entities():
                    name_elements(part.mjcf_model)
            attach = self.arena.add_free_entity if attachment.free else self.arena.attach
            frame = attach(attachment.entity)
            self.attachments[name] = attachment
            frame.pos = attachment.position
            frame.quat = attachment.quat_wxyz
        if new:
            self._uninitialised.extend(attachment.entity.iter_entities())
            self._new[name] = attachment.entity
        if max_overlap is not None:
            self._max_overlap[name] = max_overlap

    def detach(self, name: str) -> None:
        """Detach an entity."""
        entity = self.attachments.pop(name).entity
        self._new.pop(name, None)
        self._writer.forget(entity.mjcf_model)
        with self._tracker.attaching(entity.mjcf_model):
            entity.detach()

    def rename(self, entity: composer.Entity, name: str) -> None:
        """Set the model name of an entity that is not attached; this does not count as an edit."""
        with self._tracker.attaching(entity.mjcf_model):
            entity.mjcf_model.model = name

    def relocate(
        self, name: str, attachment: Attachment, *, max_overlap: float | None = None
    ) -> None:
        """Attach an entity at another pose."""
        self.attachments[name] = attachment
        model = attachment.entity.mjcf_model
        frame = mjcf.get_attachment_frame(model)
        with self._tracker.attaching(model):
            frame.pos, frame.quat = attachment.position, attachment.quat_wxyz
        if max_overlap is not None:
            self._max_overlap[name] = max_overlap

    def restore(
        self,
        entries: Sequence[Mapping[str, Any]],
        overrides: Mapping[str, Values],
        factory: Factory | None,
    ) -> None:
        """Attach exactly the described entities, with the given overrides.

        Entities that match the description at their position in the order are kept.

        Raises:
            CellError: If an entity is missing and there is no factory.
        """
        if [a.describe(name) for name, a in self.attachments.items()] != list(entries):
            with self.edit(overridden=False):
                self._attach_described(entries, factory)
        self.overrides.set_state(overrides)
        self.physics.apply_overrides(self.overrides)

    def _attach_described(
        self, entries: Sequence[Mapping[str, Any]], factory: Factory | None
    ) -> None:
        present = list(self.attachments.items())
        keep = 0
        while keep < min(len(entries), len(present)):
            name, attachment = present[keep]
            if attachment.describe(name) != entries[keep]:
                break
            keep += 1
        detached = dict(present[keep:])
        for name in detached:
            self.detach(name)
            self.overrides.remove(name)  # `restore` sets the state's overrides
        for entry in entries[keep:]:
            name = entry["name"]
            known = detached.get(name)
            if known is not None and known.describe(name) == entry:
                self.attach(name, known, new=False)
            elif factory is not None:
                entity = self._reusable_entity(entry) or factory(entry)
                self.attach(name, Attachment.described(entity, entry))
            else:
                raise CellError(
                    f"the state has a '{name}' that this cell lacks, and no factory to create it"
                )

    def is_reusable(self, entity: composer.Entity) -> bool:
        """Return whether an entity was attached before, is detached and was not edited."""
        return entity.parent is None and self._tracker.is_unedited(entity.mjcf_model)

    def _reusable_entity(self, entry: Mapping[str, Any]) -> composer.Entity | None:
        """Return a reusable entity of the cached physics that matches a description."""
        wanted = entry["name"], entry["kind"], entry["parameters"]
        for name, entity in self.cache.entities():
            known = as_object(entity)
            found = name, known.kind, dict(known.parameters)
            if found == wanted and self.is_reusable(entity):
                return entity
        return None

    # Changes

    @contextlib.contextmanager
    def change(self, failure: str, *, overridden: bool = True) -> Iterator[None]:
        """Compile the changes made inside, or undo them on failure.

        Args:
            failure: Beginning of the message of the error.
            overridden: Whether new entities get their initial overrides.

        Raises:
            CellError: If it does not compile.
        """
        if self.editing:  # the outer change compiles and undoes
            yield
            return
        overrides = self.overrides.get_state()
        try:
            with self._undone_on_error():
                yield
                old = self.physics
                self.physics = self._compile(old, self.initial_overrides if overridden else None)
                self.cache.retire(old)
        except CellError:
            self.overrides.set_state(overrides)
            raise
        except Exception as error:
            self.overrides.set_state(overrides)
            raise CellError(f"{failure}: {_reason(error)}") from error

    @contextlib.contextmanager
    def edit(self, *, overridden: bool = True) -> Iterator[None]:
        """Compile once for all changes made inside, or undo them on failure."""
        with self.change("the cell cannot be changed", overridden=overridden):
            self.editing = True
            try:
                yield
            finally:
                self.editing = False

    @contextlib.contextmanager
    def placement_search(self, name: str, attachment: Attachment) -> Iterator[PlacementSearch]:
        """Provide a copy of the physics with one more entity, to search for its free pose.

        Raises:
            CellError: If it does not compile, or the search inside fails.
        """
        failure = f"'{name}' cannot be placed"
        model_name = attachment.entity.mjcf_model.model
        uninitialised, new = list(self._uninitialised), dict(self._new)
        try:
            self.attach(name, attachment)
            try:
                copy = self._physics()
                try:
                    self._carry_state(self.physics, copy.model, copy.data)
                    yield PlacementSearch(copy.model, copy.data, name, attachment.free)
                finally:
                    self.cache.retire(copy)
            finally:
                self.detach(name)
                self._uninitialised[:], self._new = uninitialised, new
                self.rename(attachment.entity, model_name)
        except CellError as error:
            raise CellError(f"{failure}: {error}") from error
        except ValueError as error:
            raise CellError(f"{failure}: {_reason(error)}") from error

    @contextlib.contextmanager
    def _undone_on_error(self) -> Iterator[None]:
        """Restore the attachments if the body raises an error."""
        before = dict(self.attachments)
        try:
            yield
        except BaseException:
            for name, attachment in list(self.attachments.items()):
                known = before.get(name)
                if known is None or known.entity is not attachment.entity:
                    self.detach(name)
                elif known is not attachment:
                    self.relocate(name, known)
            for name, attachment in before.items():
                if name not in self.attachments:
                    self.attach(name, attachment)
            self.attachments = {name: self.attachments[name] for name in before}
            raise
        finally:
            self._uninitialised.clear()
            self._new.clear()
            self._max_overlap.clear()

    # Compiling

    def _compile(
        self, old: CompiledPhysics | None, initial_overrides: InitialOverrides | None = None
    ) -> CompiledPhysics:
        """Compile the arena and carry the state over; the old physics is not changed."""
        random_state = self._random_state
        new = self._physics()
        entities = list(self.arena.iter_entities())
        try:
            if old is not None:
                self._carry_state(old, new.model, new.data)
                mujoco.mj_forward(new.model, new.data)
            for entity in entities:
                entity.after_compile(new.physics, random_state)
            # Overrides come last, so that entities read nominal values in after_compile.
            if initial_overrides is not None:
                for name, entity in self._new.items():
                    values = initial_overrides(name, entity, new.nominal)
                    self.overrides.put(name, values, new.nominal)
            new.apply_overrides(self.overrides)
            for entity in self._uninitialised:
                entity.initialize_episode(new.physics, random_state)
            mujoco.mj_forward(new.model, new.data)
            for name, limit in reversed(self._max_overlap.items()):  # report the later entity
                verb = "added" if name in self._new else "moved"
                refuse_overlap(new.model, new.data, new.body_names, name, limit, verb)
        except BaseException:
            if old is not None:
                for entity in entities:  # bind remaining entities to the old physics again
                    if entity not in self._uninitialised:
                        entity.after_compile(old.physics, random_state)
            self.cache.retire(new)  # often the same entity is added at another pose next
            raise
        self.generation += 1
        return new

    def _carry_state(
        self, old: CompiledPhysics, model: mujoco.MjModel, data: mujoco.MjData
    ) -> None:
        """Copy the state of the remaining entities, and set the poses of new ones."""
        carry_state(old.model, old.data, model, data, except_entities=self._new)
        for name in self._new:
            attachment = self.attachments[name]
            if attachment.free:
                first = int(model.joint(f"{name}/").qposadr[0])
                data.qpos[first : first + 7] = (*attachment.position, *attachment.quat_wxyz)

    def _physics(self) -> CompiledPhysics:
        """Return the physics of the arena, cached or compiled, in its initial state."""
        key = CacheKey(
            self._tracker.arena_edits(),
            tuple((n, a.entity, a.free) for n, a in self.attachments.items()),
            tuple(self.arena.iter_entities()),
            self._writer.key(),
        )
        kept = self.cache.take(key)
        if kept is not None:
            return kept
        model = self._writer.compile(a.entity.mjcf_model for a in self.attachments.values())
        new = CompiledPhysics(model, self.arena, self.attachments)
        self.cache.register(new, key)
        return new


def _reason(error: BaseException) -> str:
    """Return the first line of MuJoCo's root cause, with the name of the element."""
    while error.__cause__ or error.__context__:
        error = error.__cause__ or error.__context__ or error
    text = str(error).strip()
    element = re.search(r"^Element name '([^']+)'", text, re.MULTILINE)
    line = (text or type(error).__name__).splitlines()[0].removeprefix("Error: ")
    if element and "mjMINVAL" in line:
        name = element[1].rstrip("/")
        return f"'{name}' moves, so it needs a positive mass [kg] and inertia [kg m^2]; or fix it"
    return f"{line} (at '{element[1]}')" if element else line
