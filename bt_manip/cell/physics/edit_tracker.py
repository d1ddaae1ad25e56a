"""Tracking of edits to an arena's MJCF and to the models attached to it."""

import contextlib
from collections.abc import Iterator
from weakref import WeakKeyDictionary

from dm_control import mjcf


class EditTracker:
    """Counts the edits of an arena's MJCF, and of models that are attached and detached over time.

    PyMJCF counts revisions by name scope, in which an attached scope includes the enclosing scopes,
    and attaching and detaching count as revisions. An edit is a revision of the model itself:
    assigning values, adding or removing elements. Writing a number into an array of an element
    (``geom.size[0] = 1``) goes unnoticed.

    All caches of a cell (texts of models, compiled physics, removed entities) are valid while these
    counts are unchanged.

    Args:
        root: The model of the arena.
    """

    def __init__(self, root: mjcf.RootElement) -> None:
        self._root = root
        self._ignored: WeakKeyDictionary[mjcf.RootElement, int] = WeakKeyDictionary()
        self._first: WeakKeyDictionary[mjcf.RootElement, tuple[int, ...]] = WeakKeyDictionary()

    def arena_edits(self) -> int:
        """Count the edits of the arena's own elements."""
        return self._edits(self._root)

    def edits(self, model: mjcf.RootElement) -> tuple[int, ...]:
        """Count the edits of a model, and of each model attached to it."""
        return tuple(self._edits(part) for part in with_attached(model))

    def is_unedited(self, model: mjcf.RootElement) -> bool:
        """Return whether a model was attached before, and not edited since."""
        return self._first.get(model) == self.edits(model)

    @contextlib.contextmanager
    def attaching(self, model: mjcf.RootElement) -> Iterator[None]:
        """Attach, detach, move or name the elements of a model without counting edits."""
        self._first.setdefault(model, self.edits(model))
        before = [(part, self._revision(part)) for part in (self._root, *with_attached(model))]
        yield
        for part, revision in before:
            self._ignored[part] = self._ignored.get(part, 0) + self._revision(part) - revision

    def _edits(self, part: mjcf.RootElement) -> int:
        return self._revision(part) - self._ignored.get(part, 0)

    def _revision(self, part: mjcf.RootElement) -> int:
        attached = part is not self._root and part.root_model is self._root
        around = self._root.namescope.revision if attached else 0
        return int(part.namescope.revision - around)


def attached_to(model: mjcf.RootElement) -> list[mjcf.RootElement]:
    """Return the models attached to a model, in order."""
    # PyMJCF has no other access to empty attached models.
    return list(model._attachments.values())


def with_attached(model: mjcf.RootElement) -> Iterator[mjcf.RootElement]:
    """Yield a model and, recursively, all models attached to it."""
    yield model
    for part in attached_to(model):
        yield from with_attached(part)
