"""Replacing a running tree between two ticks."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_manip.bt.blackboard import Blackboard
from bt_manip.exceptions import TreeError

if TYPE_CHECKING:
    from bt_manip.bt.loading import Reading
    from bt_manip.bt.registry import BehaviourRegistry
    from bt_manip.bt.tree import Tree


def replace(tree: "Tree", other: "Tree") -> None:
    """Let `tree` go on as `other`.

    What runs is halted. The entries of every scope that both trees have stay, with those that only
    the new tree declares added. Observers and infrastructure stay.

    Args:
        tree: The tree that runs.
        other: A tree that has not run; it must not be used afterwards.

    Raises:
        NodeError: If a behaviour of the new tree fails in its ``setup``; the old tree is halted
            then, and stays.
    """
    tree.halt()
    if tree._infrastructure is not None:
        other.setup(**tree._infrastructure)
    runtime = tree._runtime
    for path, scope in other.scopes.items():
        old = tree.scopes.get(path)
        if old is not None:
            _keep_entries(old, scope)
    runtime.timers.clear()
    runtime.wake_up = False
    runtime.reason = None
    runtime.enums.update(other._runtime.enums)
    tree.root = other.root
    tree.tree_id = other.tree_id
    tree.document = other.document
    tree.nodes = other.nodes
    tree.scopes = other.scopes
    tree._root = other._root
    tree._has_foreign = other._has_foreign
    for link in tree.nodes:
        link._node_runtime = runtime
        link._node_observers = runtime.observers


def _keep_entries(old: Blackboard, new: Blackboard) -> None:
    """Keep what was written, unless the new tree gives the key another type or meaning."""
    for key, entry in old.entries.items():
        fresh = new.entries.get(key)
        if key in new.remapped:
            continue
        if fresh is None:
            new.entries[key] = entry
        elif fresh.sequence == 0 and (
            not fresh.declared.strong
            or fresh.declared == entry.declared
            or not entry.declared.strong
        ):
            new.entries[key] = entry


class TreeWatch:
    """Looks whether the files of a running tree were edited, and replaces the tree if so."""

    def __init__(self, tree: "Tree", registry: "BehaviourRegistry", **options: Any) -> None:
        """Watch the files that a tree was read from, included ones too.

        Args:
            tree: The tree that runs; it was read from a file.
            registry: The behaviours that its files may name.
            **options: As of `load_tree`: ``main``, ``dialect``, ``libraries``, ``strict``.

        Raises:
            TreeError: If the tree was not read from a file.
        """
        if tree.source is None:
            raise TreeError(f"the tree {tree.tree_id} was not read from a file")
        self._tree = tree
        self._registry = registry
        self._options: Mapping[str, Any] = options
        self._path = tree.source
        self._seen = self._stamps()

    def poll(self) -> "Reading | None":
        """Replace the tree if a file has changed since the last call; to be called between ticks.

        Returns:
            What came of reading the changed files; None if none has changed. If it holds errors,
            the tree goes on as it was.

        Raises:
            NodeError: If a node raised an exception while it was halted or set up.
        """
        stamps = self._stamps()
        if stamps == self._seen:
            return None
        self._seen = stamps
        from bt_manip.bt.loading import read_tree

        try:
            reading = read_tree(self._path, self._registry, clock=self._tree.clock, **self._options)
        except TreeError:
            return None  # an editor is just writing it anew: the next call finds it
        if reading.tree is not None and not reading.errors:
            self._tree.replace(reading.tree)
            self._seen = self._stamps()
        return reading

    def _stamps(self) -> dict[Path, int]:
        document = self._tree.document
        files = [self._path] if document is None else document.files
        return {file: file.stat().st_mtime_ns for file in files if file.exists()}
