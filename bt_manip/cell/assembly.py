"""An arena and the physics compiled from it, which change together or not at all."""

import contextlib
import re
from collections.abc import Callable, Iterator

import mujoco
import numpy as np
from dm_control import composer

from bt_manip.cell.contacts.overlap import refuse_overlap
from bt_manip.cell.exceptions import CellError
from bt_manip.cell.inventory import Inventory
from bt_manip.cell.physics.attachment import Attachment
from bt_manip.cell.physics.compiled_physics import CompiledPhysics
from bt_manip.cell.physics.overrides import Overrides, Values
from bt_manip.cell.physics.physics_cache import PhysicsCache
from bt_manip.cell.physics.state import carry_state
from bt_manip.cell.probe import Probe

InitialOverrides = Callable[[str, composer.Entity, mujoco.MjModel], Values]
"""Tells of an entity that comes in, by name, how it differs from the model that was compiled."""


class Assembly:
    """Compiles an arena whenever what stands in it has changed, and undoes changes that fail.

    Attributes:
        inventory: What stands in the arena.
        compiled: The physics of now, and what follows from it.
        generation: Counts the compiles.
        editing: Whether several changes are under way, which are compiled together.
        alterations: How the physics differs from the models.
        vary: Asked of what comes in how it differs; nobody at first.
        cache: Keeps physics for when the same things stand in the arena again.
    """

    def __init__(self, arena: composer.Arena, random_state: np.random.RandomState):
        """Compile an arena for the first time.

        Args:
            arena: The arena.
            random_state: What composer's hooks get to draw from.
        """
        self.inventory = Inventory(arena)
        self.generation = 0
        self.editing = False
        self.overrides = Overrides()
        self.initial_overrides: InitialOverrides | None = None
        self.cache = PhysicsCache()
        self._random_state = random_state
        self.compiled = self._compile(None)
        self.inventory.settle()

    @contextlib.contextmanager
    def change(self, failure: str, *, varied: bool = True) -> Iterator[None]:
        """Compile what is changed inside, or undo the change.

        Args:
            failure: What cannot be done, for the message.
            varied: Whether what comes in gets to differ from its model.

        Raises:
            CellError: When it does not compile.
        """
        if self.editing:  # whoever edits compiles, and undoes
            yield
            return
        altered = self.overrides.get_state()
        try:
            with self.inventory.changing():
                yield
                old = self.compiled
                self.compiled = self._compile(old, self.initial_overrides if varied else None)
                self.cache.retire(old)
        except CellError:
            self.overrides.set_state(altered)
            raise
        except Exception as error:
            self.overrides.set_state(altered)
            raise CellError(f"{failure}: {_reason(error)}") from error

    @contextlib.contextmanager
    def edit(self, *, varied: bool = True) -> Iterator[None]:
        """Compile once for all changes inside, or undo them."""
        with self.change("the cell cannot be changed", varied=varied):
            self.editing = True
            try:
                yield
            finally:
                self.editing = False

    @contextlib.contextmanager
    def probe(self, name: str, placement: Attachment) -> Iterator[Probe]:
        """Give a copy with one thing more, to try out where it could stand.

        Raises:
            CellError: When it does not compile, or what is tried inside raises one.
        """
        failure = f"'{name}' cannot be placed"
        try:
            with self.inventory.trying(name, placement) as model:
                data = mujoco.MjData(model)
                carry_state(self.compiled.model, self.compiled.data, model, data)
                yield Probe(model, data, name, placement.free)
        except CellError as error:
            raise CellError(f"{failure}: {error}") from error
        except ValueError as error:
            raise CellError(f"{failure}: {_reason(error)}") from error

    def _compile(
        self, old: CompiledPhysics | None, vary: InitialOverrides | None = None
    ) -> CompiledPhysics:
        """Compile the arena and carry the state over; the old physics is left as it is."""
        inventory, random_state = self.inventory, self._random_state
        new = self._physics()
        entities = list(inventory.arena.iter_entities())
        try:
            if old is not None:
                carry_state(old.model, old.data, new.model, new.data, strangers=inventory.arrived)
                mujoco.mj_forward(new.model, new.data)
            for entity in entities:
                entity.after_compile(new.physics, random_state)
            # Only now: what the entities take from the model is what can be known of it.
            if vary is not None:
                for name, entity in inventory.arrived.items():
                    self.overrides.put(name, vary(name, entity, new.nominal), new.nominal)
            new.apply_overrides(self.overrides)
            for entity in inventory.fresh:
                entity.initialize_episode(new.physics, random_state)
            mujoco.mj_forward(new.model, new.data)
            for name, accepted in reversed(inventory.accepted.items()):  # blame the later one
                verb = "added" if name in inventory.arrived else "moved"
                refuse_overlap(new.model, new.data, new.labels, name, accepted, verb)
        except BaseException:
            self.cache.forget(new)
            if old is not None:
                for entity in entities:  # those that stay look at the old physics again
                    if entity not in inventory.fresh:
                        entity.after_compile(old.physics, random_state)
            raise
        self.generation += 1
        return new

    def _physics(self) -> CompiledPhysics:
        """Give the physics of what stands in the arena, with nothing carried over yet."""
        inventory = self.inventory
        key = inventory.key() if self.cache.limit else None
        known = None if key is None else self.cache.take(key)
        if known is not None:
            return known
        new = CompiledPhysics(inventory.compile(), inventory.arena, inventory.placed)
        if key is not None:
            self.cache.note(new, key)
        return new


def _reason(error: BaseException) -> str:
    """Give what says most: MuJoCo's first line, and the name of the element it is about."""
    while error.__cause__ or error.__context__:
        error = error.__cause__ or error.__context__ or error
    text = str(error).strip()
    element = re.search(r"^Element name '([^']+)'", text, re.MULTILINE)
    line = (text or type(error).__name__).splitlines()[0].removeprefix("Error: ")
    return f"{line} (at '{element[1]}')" if element else line
