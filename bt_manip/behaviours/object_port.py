"""Ports that name objects of the cell."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from bt_manip.bt import Condition, Input, Node, Tree, matches
from bt_manip.cell import CellError, as_object
from bt_manip.exceptions import BtManipError, did_you_mean

KIND_PREFIX = "kind:"
"""Prefix of a registered name or address, for all objects that were made of it."""


class ObjectInput(Input):
    """A port with the name of an object, or with ``list[str]`` the names of several.

    A list may contain patterns, ``part_*``, and kinds, ``kind:cube``. They stand for the objects
    that the cell has, or expects, when the tree is set up; in an entry of the blackboard, for those
    at the time of reading.
    """

    def reader(
        self, read: Callable[[], Any], fixed: bool, infrastructure: Mapping[str, Any]
    ) -> Callable[[], Any]:
        """Return the function that reads names of objects for patterns and kinds in a list.

        Raises:
            CellError: If there is no object for one of them; also when an entry is read.
        """
        if self.type.python is str:
            return read
        if not fixed:
            return lambda: matching_objects(read(), infrastructure)
        names = matching_objects(read(), infrastructure)
        return lambda: list(names)


def is_pattern(text: str) -> bool:
    """Return whether a text is a pattern of names or a kind, not a name."""
    return text.startswith(KIND_PREFIX) or not set(text).isdisjoint("*?")


def matching_objects(texts: Iterable[str], infrastructure: Mapping[str, Any]) -> list[str]:
    """Return the names of objects for names, patterns and kinds, each once.

    Args:
        texts: Names, which need not exist, patterns such as ``part_*``, and kinds: ``kind:cube``.
        infrastructure: As of `Station.infrastructure`.

    Raises:
        CellError: If there is no object for a pattern or kind.
    """
    kinds, names = _kinds_of_objects(infrastructure), list[str]()
    for text in texts:
        kind = text.removeprefix(KIND_PREFIX)
        found = [n for n, k in kinds.items() if (k == kind if kind != text else matches(n, text))]
        if not found and is_pattern(text):
            there = ", ".join(f"{name} ({kind})" for name, kind in kinds.items()) or "none"
            raise CellError(f"no object is called '{text}'; there are {there}")
        names += found or [text]
    return list(dict.fromkeys(names))


def _kinds_of_objects(infrastructure: Mapping[str, Any]) -> dict[str, str]:
    """Return the kinds of the objects in the cell, and of those that it expects, by name."""
    entities, expected = infrastructure["cell"].objects.items(), infrastructure.get("poses")
    kinds = {name: as_object(entity).kind or "" for name, entity in entities}
    more = () if expected is None else expected.source.expected
    return kinds | {scene_object.name: scene_object.model for scene_object in more}


def check_objects(tree: Tree, infrastructure: Mapping[str, Any], more: Iterable[str] = ()) -> None:
    """Check that the objects which a tree names are in the cell, or that a node adds them.

    Args:
        tree: A tree that was set up.
        infrastructure: As of `Station.infrastructure`.
        more: Objects that are in the cell when the tree begins.

    Raises:
        BtManipError: With the place of each port that names an unknown object.
    """
    nodes = [node for node in (*tree.nodes, *tree.goal) if isinstance(node, Node)]
    known = {*_kinds_of_objects(infrastructure), *infrastructure["cell"].entities, *more}
    added = [pattern for node in nodes for pattern in getattr(node, "adds_objects", ())]
    problems = []
    for node in nodes:
        for port in node.ports.values():
            if not isinstance(port, ObjectInput):
                continue
            key, names = node.key_of(port.name), tree.constants.get((node.path, port.name), "")
            if key is None:
                names = node.read_port(port.name)
            elif key in node.scope and node.scope[key] != names:
                continue  # it was written since the tree was read
            for name in [names] if isinstance(names, str) else names or ():
                if is_pattern(name) and isinstance(node, Condition) and node.goal_conditions:
                    continue
                entity = name.partition("/")[0]  # of a geom
                if name and not (entity in known or any(matches(entity, one) for one in added)):
                    where = tree.place_of(node.path) or node.path
                    near = did_you_mean(name, known)
                    text = f"{where}: port '{port.name}' of {node.name}: no object '{name}'{near}"
                    problems.append(text)
    if problems:
        raise BtManipError("\n".join(dict.fromkeys(problems)))
