"""Watch the files of a running tree, and replace the tree when they change."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from bt_manip.bt.libraries import Libraries
from bt_manip.bt.loading import Reading, read_tree
from bt_manip.bt.reading_options import DEFAULTS, ReadingOptions
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.tree import Tree
from bt_manip.exceptions import TreeError


class TreeWatch:
    """Replaces a running tree when one of its files, included ones too, was edited.

    The files are read as `options` and `changes` say; the clock stays that of the tree.

    Raises:
        TreeError: If the tree was not read from a file.
    """

    def __init__(
        self,
        tree: Tree,
        registry: BehaviourRegistry,
        options: ReadingOptions = DEFAULTS,
        **changes: Any,
    ) -> None:
        if tree.source is None:
            raise TreeError(f"the tree {tree.tree_id} was not read from a file")
        self._tree = tree
        self._registry = registry
        self._options = replace(options, **changes)
        self._path = tree.source
        self._seen = self._stamps()

    def poll(self, check: Callable[[Tree], None] = lambda tree: None) -> Reading | None:
        """Replace the tree if a file has changed since the last call; to be called between ticks.

        The tree goes on as it was if the result, which is None without a change, holds errors, or
        if `check` raises, which gets the edited tree before.

        Raises:
            NodeError: If a node raised an exception while it was halted or set up.
        """
        stamps = self._stamps()
        if stamps == self._seen:
            return None
        self._seen = stamps
        options = replace(self._options, clock=self._tree.clock)
        if isinstance(options.libraries, Libraries):
            options = replace(options, libraries=options.libraries.paths)  # read anew
        try:
            reading = read_tree(self._path, self._registry, options)
        except TreeError:
            return None  # an editor is just writing it anew: the next call finds it
        if reading.tree is not None and not reading.errors:
            check(reading.tree)
            self._tree.replace(reading.tree)
            self._seen = self._stamps()
        return reading

    def _stamps(self) -> dict[Path, int]:
        document = self._tree.document
        files = [self._path] if document is None else document.files
        return {file: file.stat().st_mtime_ns for file in files if file.exists()}
