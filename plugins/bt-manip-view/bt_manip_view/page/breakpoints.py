"""Breakpoints: set on the page, named by an option, or marked in the file of a tree."""

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from bt_manip.bt import Tree
from bt_manip.exceptions import did_you_mean

ATTRIBUTE = "_break"
"""Attribute of a node in a document that sets a breakpoint: ``_break="true"``."""

_NUMBER = re.compile(r"::\d+")  # of a node without a name of its own, in its path

Key = tuple[str, int]
"""A path without numbers, and how many nodes before have the same; an edit seldom changes it."""


class Breakpoints:
    """Breakpoints of each tree that a page shows; they stay over edits and further runs.

    Breakpoints of an option or a document are set when they are seen first: one that was removed
    on the page stays removed.

    Attributes:
        names: Names or paths of nodes that have one in any tree.
        paths: Paths of the nodes of the present tree that have one.
    """

    def __init__(self) -> None:
        self.names: tuple[str, ...] = ()
        self.paths: frozenset[str] = frozenset()
        self._tree = ""
        self._keys: dict[str, Key] = {}
        self._set = defaultdict[str, set[Key]](set)  # by tree
        self._seen = defaultdict[str, set[Key]](set)  # of names and documents, by tree

    def show(self, tree: str, nodes: Sequence[Mapping[str, Any]], marked: Iterable[str]) -> None:
        """Take up the breakpoints of a tree, whose document marks some nodes by their paths."""
        counts = Counter[str]()
        self._tree, self._keys = tree, {}
        for path in (node["path"] for node in nodes):
            plain = _NUMBER.sub("", path)
            self._keys[path] = plain, counts[plain]
            counts[plain] += 1
        paths = {path for name in self.names for path in paths_of(name, nodes)}
        given = {self._keys[path] for path in paths.union(marked)}
        self._set[tree] |= given - self._seen[tree]
        self._seen[tree] |= given
        self._find_paths()

    def choose(self, paths: Collection[str]) -> None:
        """Replace the breakpoints of the present tree; before there is one, those of any tree."""
        if self._keys:
            self._set[self._tree] = {self._keys[path] for path in paths if path in self._keys}
            self._find_paths()
        else:
            self.names, self.paths = tuple(paths), frozenset(paths)

    def _find_paths(self) -> None:
        present = self._set[self._tree]
        self.paths = frozenset(path for path, key in self._keys.items() if key in present)


def paths_of(name: str, nodes: Iterable[Mapping[str, Any]]) -> set[str]:
    """Return the paths of the nodes that have a name or a path, or whose path ends with it."""
    return {
        path
        for path, own in ((node["path"], node["name"]) for node in nodes)
        if name in (path, own) or f"/{_NUMBER.sub('', path)}".endswith(f"/{name}")
    }


def problem_of(names: Iterable[str], nodes: Sequence[Mapping[str, Any]]) -> str:
    """Return a message about the first name that no node has; empty if there is none."""
    for name in names:
        if not paths_of(name, nodes):
            hint = did_you_mean(name, [node["name"] for node in nodes])
            return f"breakpoint: no node is called '{name}'{hint}"
    return ""


def split_names(text: str) -> tuple[str, ...]:
    """Return the names in the text of an option, which are separated by ``;``."""
    return tuple(filter(None, map(str.strip, text.split(";"))))


def nodes_of(tree: Tree) -> list[dict[str, str]]:
    """Return path and name of each node of a tree."""
    return [{"path": node.path, "name": node.name} for node in tree.nodes]


def marked_paths(tree: Tree) -> set[str]:
    """Return the paths of the nodes that the document of a tree marks by `ATTRIBUTE`."""
    if tree.document is None:
        return set()
    places = {
        str(element.place)
        for one in tree.document.trees.values()
        for element in one.iterate()
        if element.get(ATTRIBUTE) == "true"
    }
    return {n.path for n in tree.nodes if tree.place_of(n.path) in places} if places else set()
