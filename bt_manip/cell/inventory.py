"""What stands in an arena."""

import contextlib
from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any

import mujoco
from dm_control import composer, mjcf

from bt_manip.cell.exceptions import CellError
from bt_manip.cell.naming import name_elements
from bt_manip.cell.physics.attachment import Attachment, Factory
from bt_manip.cell.physics.mjcf_writer import MjcfWriter
from bt_manip.cell.spares import Spares
from bt_manip.exceptions import did_you_mean


class Inventory:
    """The entities of an arena by name, in order; changes can be undone."""

    def __init__(self, arena: composer.Arena):
        """Begin with an arena; what it already holds is not listed, but counts as new."""
        self.arena = arena
        self.placed: dict[str, Attachment] = {}
        self._writer = MjcfWriter(arena.mjcf_model)
        self._revisions = 0  # of the arena's model, by what came, went and was moved
        self.fresh: list[composer.Entity] = list(arena.iter_entities())
        """Entities that have come since the last compile and want to be initialised."""
        self.arrived: dict[str, composer.Entity] = {}
        """The same by name, without what is attached to them."""
        self.accepted: dict[str, float] = {}
        """How deep what has come since the last compile may be inside something else [m]."""
        self.spares = Spares(self._writer.changes)

    def find(self, name: str) -> Attachment:
        """Give the placement of a name.

        Raises:
            CellError: When there is none; the nearest names are offered.
        """
        try:
            return self.placed[name]
        except KeyError:
            near = did_you_mean(name, self.placed)
            raise CellError(f"there is no '{name}' in the cell{near}") from None

    def attach(self, name: str, placement: Attachment, *, fresh: bool = True) -> None:
        """Put an entity into the arena, under a name."""
        entity, changes = placement.entity, self._writer.changes
        has_names = changes.none(entity.mjcf_model)  # and has been here before
        with self._revising(), changes.travelling(entity.mjcf_model):
            entity.mjcf_model.model = name
            if not has_names:
                for part in entity.iter_entities():
                    name_elements(part.mjcf_model)
            attach = self.arena.add_free_entity if placement.free else self.arena.attach
            frame = attach(entity)
            self.placed[name] = placement
            frame.pos = placement.position
            frame.quat = placement.quat_wxyz
        if fresh:
            self.fresh.extend(entity.iter_entities())
            self.arrived[name] = entity

    def detach(self, name: str) -> None:
        """Take an entity out of the arena."""
        placement = self.placed.pop(name)
        self.arrived.pop(name, None)
        model = placement.entity.mjcf_model
        self._writer.forget(model)
        with self._revising(), self._writer.changes.travelling(model):
            placement.entity.detach()
        self.spares.keep(name, placement)

    def relocate(self, name: str, placement: Attachment) -> None:
        """Put an entity that is here at another pose."""
        self.placed[name] = placement
        frame = mjcf.get_attachment_frame(placement.entity.mjcf_model)
        with self._revising():
            frame.pos, frame.quat = placement.position, placement.quat_wxyz

    def settle(self) -> None:
        """Take what has come as known."""
        self.fresh.clear()
        self.arrived.clear()
        self.accepted.clear()

    def is_as(self, entries: Sequence[Mapping[str, Any]]) -> bool:
        """Tell whether what stands here is what was described, in the same order."""
        return [p.describe(name) for name, p in self.placed.items()] == list(entries)

    def become(self, entries: Sequence[Mapping[str, Any]], factory: Factory | None) -> None:
        """Take out and put in entities until what stands here is what was described.

        What already stands at its place in the order, alike in name and kind, stays what it is.

        Raises:
            CellError: When an entity is missing and there is no factory to make it.
        """
        present = list(self.placed.items())
        keep = 0
        while keep < min(len(entries), len(present)):
            name, placement = present[keep]
            if placement.describe(name) != entries[keep]:
                break
            keep += 1
        spare = dict(present[keep:])
        for name in spare:
            self.detach(name)
        for entry in entries[keep:]:
            name = entry["name"]
            known = spare.get(name)
            if known is not None and known.describe(name) == entry:
                self.attach(name, known, fresh=False)
            elif factory is not None:
                self.attach(name, self.spares.take(entry) or Attachment.made(entry, factory))
            else:
                raise CellError(
                    f"the state has a '{name}' that this cell lacks, and no way to make it"
                )

    @contextlib.contextmanager
    def _revising(self) -> Iterator[None]:
        """Count the changes of the arena's model that leave its own elements as they are."""
        scope = self.arena.mjcf_model.namescope
        before = scope.revision
        yield
        self._revisions += scope.revision - before

    def key(self) -> Hashable:
        """Give what is equal only for arenas that are compiled to the same."""
        own = self.arena.mjcf_model.namescope.revision - self._revisions
        entities = tuple(self.arena.iter_entities())
        return own, tuple(self.placed.items()), entities, self._writer.key()

    def compile(self) -> mujoco.MjModel:
        """Compile the arena.

        Raises:
            ValueError: When MuJoCo or PyMJCF refuses it.
        """
        return self._writer.compile(p.entity.mjcf_model for p in self.placed.values())

    @contextlib.contextmanager
    def changing(self) -> Iterator[None]:
        """Put everything back as it was when what is done inside raises."""
        before = dict(self.placed)
        try:
            yield
        except BaseException:
            for name, placement in list(self.placed.items()):
                known = before.get(name)
                if known is None or known.entity is not placement.entity:
                    self.detach(name)
                elif known is not placement:
                    self.relocate(name, known)
            for name, placement in before.items():
                if name not in self.placed:
                    self.attach(name, placement)
            self.placed = {name: self.placed[name] for name in before}
            raise
        finally:
            self.settle()

    @contextlib.contextmanager
    def trying(self, name: str, placement: Attachment) -> Iterator[mujoco.MjModel]:
        """Give the model with one thing more, and take that out again."""
        model_name = placement.entity.mjcf_model.model
        fresh, arrived = list(self.fresh), dict(self.arrived)
        self.attach(name, placement)
        try:
            yield self.compile()
        finally:
            self.detach(name)
            self.fresh[:], self.arrived = fresh, arrived
            placement.entity.mjcf_model.model = model_name
