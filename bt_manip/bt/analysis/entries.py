"""The entries of the blackboard that the nodes of a bound tree read, write and mention."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final, NamedTuple

from bt_manip.bt.analysis.facts import EntryName, variable_of
from bt_manip.bt.blackboard import EMPTY, Blackboard
from bt_manip.bt.nodes.actions.blackboard import SetBlackboard, UnsetBlackboard, Watching
from bt_manip.bt.nodes.actions.script import Script, ScriptPort
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.ports import is_pointer, pointed_key
from bt_manip.bt.script.parser import ParsedScript, parse_script
from bt_manip.bt.xml.problem import Place
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import ScriptError

ROBOT: Final = "robot"
"""Port of behaviours of a robot, and the entry of the scope that they read without it."""


class Use(NamedTuple):
    """A place where an entry is read or written.

    Attributes:
        node: The node.
        scope: The scope of the node.
        key: The key in that scope.
        place: The attribute of the node.
        port: The port, a `Port`; None in a script.
        is_needed: Whether the node cannot do without a value that was written before.
        is_early: Whether it is read when the node is ticked, and not afterwards.
    """

    node: Node
    scope: Blackboard
    key: str
    place: Place
    port: Any = None
    is_needed: bool = True
    is_early: bool = True

    @property
    def entry(self) -> EntryName:
        """The entry that the key means."""
        return variable_of(self.scope, self.key)


class Uses:
    """All uses of entries in a tree.

    Args:
        nodes: The nodes of a bound tree, with those of its goal.
        places: The elements of the nodes.

    Attributes:
        reads: Where entries are read.
        writes: Where entries are written.
        mentions: The keys that are used in each scope, sub-trees' remaps included.
    """

    def __init__(self, nodes: Iterable[Any], places: Mapping[int, Element]) -> None:
        self.reads: list[Use] = []
        self.writes: list[Use] = []
        self.mentions: dict[int, dict[str, None]] = {}
        for node in nodes:
            element = places.get(id(node))
            if isinstance(node, Node) and element is not None:
                self._add_ports(node, element)
                for name, script, place in scripts_of(node, element):
                    self._add_script(node, name, script, place)
                if isinstance(node, SubTree):
                    for text in node.remaps.values():
                        if is_pointer(text):
                            self._mention(node.scope, text.strip(" ")[1:-1])

    def _mention(self, scope: Blackboard, key: str) -> None:
        if key[:1] == "@":
            scope, key = scope.root, key[1:]
        self.mentions.setdefault(id(scope), {})[key] = None
        if scope.autoremap and scope.parent is not None and key not in scope.remapped:
            self._mention(scope.parent, key)

    def _add_ports(self, node: Node, element: Element) -> None:
        for name, port in node.ports.items():
            text = node.port_text(name)
            given = node.given.get(name, port.default)
            text = given if text is None and isinstance(given, str) else text
            attribute = element.attributes.get(name)
            place = element.place if attribute is None else attribute.value_place
            key = None if text is None else pointed_key(name, text)
            if name == ROBOT and not text:
                self._mention(node.scope, ROBOT)
            if key is None:
                if isinstance(node, SetBlackboard) and name == "output_key" and text:
                    self._mention(node.scope, text)
                    self.writes.append(Use(node, node.scope, text, place, port))
                elif isinstance(node, UnsetBlackboard) and text:
                    self._mention(node.scope, text)
                continue
            self._mention(node.scope, key)
            use = Use(node, node.scope, key, place, port)
            if port.reads:
                is_needed = not port.writes and not isinstance(node, Watching)
                self.reads.append(use._replace(is_needed=is_needed))
            if port.writes:
                self.writes.append(use)

    def _add_script(self, node: Node, name: str, script: ParsedScript, place: Place) -> None:
        is_early = not name.startswith(("_on", "_post"))
        enums = node.runtime.enums
        for key in sorted(script.reads | script.writes):
            self._mention(node.scope, key)
            use = Use(node, node.scope, key, place, None, key not in script.writes, is_early)
            if key in script.writes:
                self.writes.append(use)
            if key in script.reads and key not in enums:
                self.reads.append(use)


def scripts_of(node: Node, element: Element) -> Iterator[tuple[str, ParsedScript, Place]]:
    """Give the scripts of a node: the name of the attribute, the script and its place."""
    names = list(node.conditions)
    if isinstance(node, ScriptPort):
        names.append(node.checked_port)
    for name in names:
        text = node.conditions.get(name) or str(node.given.get(name, ""))
        attribute = element.attributes.get(name)
        if attribute is not None and text and not is_pointer(text):
            try:
                yield name, parse_script(text, double_quotes=True), attribute.value_place
            except ScriptError:
                continue  # reported where the node was made


def is_plain_assignment(use: Use) -> bool:
    """Return whether an entry is only written for others, by Script or SetBlackboard."""
    return isinstance(use.node, Script | SetBlackboard)


def constants(nodes: Iterable[Any]) -> Iterator[tuple[EntryName, Any, Any]]:
    """Give the entries that have a value before the run, with the value and its type."""
    scopes: dict[int, Blackboard] = {}
    for node in nodes:
        if isinstance(node, Node):
            scopes[id(node.scope)] = node.scope
            if isinstance(node, SubTree):
                scopes[id(node.inner_scope)] = node.inner_scope
    for scope in scopes.values():
        for key, entry in scope.entries.items():
            if entry.value is not EMPTY:
                yield EntryName(id(scope), key), entry.value, entry.type
