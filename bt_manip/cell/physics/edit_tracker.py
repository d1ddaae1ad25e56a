"""How often models have been changed themselves, wherever they were meanwhile."""

import contextlib
from collections.abc import Iterator
from weakref import WeakKeyDictionary

from dm_control import mjcf


class EditTracker:
    """Counts the changes of models that come to an arena, go, and come again.

    A name scope counts its revisions. While its model is attached, those of the scopes around it
    are counted too; coming and going are counted as well. What is left without them is what was
    changed in the model itself.
    """

    def __init__(self, root: mjcf.RootElement) -> None:
        """Count for what is attached to a model.

        Args:
            root: The model of the arena.
        """
        self._root = root
        self._none: WeakKeyDictionary[mjcf.RootElement, int] = WeakKeyDictionary()
        self._first: WeakKeyDictionary[mjcf.RootElement, tuple[int, ...]] = WeakKeyDictionary()

    def of(self, model: mjcf.RootElement) -> tuple[int, ...]:
        """Count the changes of a model, and of each that is attached to it."""
        return tuple(self._count(part) - self._none.get(part, 0) for part in with_attached(model))

    def none(self, model: mjcf.RootElement) -> bool:
        """Tell whether a model is what it was when it came for the first time."""
        return self._first.get(model) == self.of(model)

    @contextlib.contextmanager
    def travelling(self, model: mjcf.RootElement) -> Iterator[None]:
        """Let a model come or go without a change."""
        self._first.setdefault(model, self.of(model))
        before = [(part, self._count(part)) for part in with_attached(model)]
        yield
        for part, count in before:
            self._none[part] = self._none.get(part, 0) + self._count(part) - count

    def _count(self, part: mjcf.RootElement) -> int:
        around = self._root.namescope.revision if part.root_model is self._root else 0
        return int(part.namescope.revision - around)


def attached_to(model: mjcf.RootElement) -> list[mjcf.RootElement]:
    """Give the models that are attached to one, in order."""
    # The only way that PyMJCF has to ask for them, if they may be empty.
    return list(model._attachments.values())


def with_attached(model: mjcf.RootElement) -> Iterator[mjcf.RootElement]:
    """Give a model, and all that are attached to it or to those."""
    yield model
    for part in attached_to(model):
        yield from with_attached(part)
