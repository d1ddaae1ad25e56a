"""Watch the files of a running tree, and replace the tree when they change."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bt_manip.bt.libraries import Libraries
from bt_manip.bt.loading import Reading, read_tree
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.tree import Tree
from bt_manip.exceptions import TreeError


class TreeWatch:
    """Replaces a running tree when one of its files was edited."""

    def __init__(self, tree: Tree, registry: BehaviourRegistry, **options: Any) -> None:
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

    def poll(self) -> Reading | None:
        """Replace the tree if a file has changed since the last call; to be called between ticks.

        Returns:
            The result of reading the changed files; None if none has changed. If it holds errors,
            the tree goes on as it was.

        Raises:
            NodeError: If a node raised an exception while it was halted or set up.
        """
        stamps = self._stamps()
        if stamps == self._seen:
            return None
        self._seen = stamps
        options = dict(self._options)
        if isinstance(options.get("libraries"), Libraries):
            options["libraries"] = Libraries(options["libraries"].paths)  # read anew
        try:
            reading = read_tree(self._path, self._registry, clock=self._tree.clock, **options)
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
