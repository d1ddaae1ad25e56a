"""The entries of the blackboard that the nodes of a bound tree read, write and mention."""

from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

from bt_manip.bt.analysis.facts import EntryName, variable_of
from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.nodes.actions.blackboard import SetBlackboard, UnsetBlackboard, Watching
from bt_manip.bt.nodes.actions.script import ScriptPort
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.port_types import PortType
from bt_manip.bt.ports import Port, is_pointer, pointed_key
from bt_manip.bt.script.evaluation import Environment, is_true
from bt_manip.bt.script.parser import ParsedScript
from bt_manip.bt.xml.problem import Place
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import BtManipError, ScriptError

ROBOT: Final = "robot"
"""Port of behaviours of a robot, and the entry of the scope that they read without it."""


class Use(NamedTuple):
    """A place where an entry is read or written.

    Attributes:
        node: The node.
        key: The key in its scope.
        place: The place of the key.
        type: The type of the port; None in a script.
        is_needed: Whether the node cannot do without a value that was written before.
        is_early: Whether it is read when the node is ticked, and not afterwards.
    """

    node: Node
    key: str
    place: Place
    type: PortType | None = None
    is_needed: bool = True
    is_early: bool = True

    @property
    def entry(self) -> EntryName:
        """The entry that the key means."""
        return variable_of(self.node.scope, self.key)


class Uses:
    """All uses of entries by the nodes of a bound tree and of its goal.

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
            if element is None or not isinstance(node, Node):
                continue
            for name, port in node.ports.items():
                self._add_port(node, port, value_place(element, name))
            for name, script in scripts_of(node).items():
                self._add_script(node, name, script, value_place(element, name))
            if isinstance(node, SubTree):
                for name, text in node.remaps.items():
                    if key := pointed_key(name, text):
                        self._mention(node.scope, key)

    def _mention(self, scope: Blackboard, key: str) -> None:
        if key[:1] == "@":
            scope, key = scope.root, key[1:]
        self.mentions.setdefault(id(scope), {})[key] = None
        if scope.autoremap and scope.parent is not None and key not in scope.remapped:
            self._mention(scope.parent, key)

    def _add_port(self, node: Node, port: Port, place: Place) -> None:
        key, text = node.key_of(port.name), node.port_text(port.name)
        reads, writes, is_robot = port.reads, port.writes, port.name == ROBOT and not text
        if isinstance(node, SetBlackboard) and port.name == "output_key":
            key, reads, writes = key or text, key is not None, key is None
        elif key is None and isinstance(node, UnsetBlackboard | Watching):
            key, reads = text, isinstance(node, Watching)
        elif is_robot:
            key = ROBOT
        if key:
            self._mention(node.scope, key)
            is_needed, is_early = not writes and not is_robot, not isinstance(node, Watching)
            use = Use(node, key, place, port.type, is_needed, is_early)
            self.reads += [use] * reads
            self.writes += [use] * writes

    def _add_script(self, node: Node, name: str, script: ParsedScript, place: Place) -> None:
        is_early = not name.startswith(("_on", "_post"))
        for key in sorted(script.reads | script.writes):
            self._mention(node.scope, key)
            use = Use(node, key, place, None, key not in script.writes, is_early)
            self.writes += [use] * (key in script.writes)
            self.reads += [use] * (key in script.reads and key not in node.runtime.enums)


def value_place(element: Element, name: str) -> Place:
    """Return the place of an attribute's value; that of the element without the attribute."""
    attribute = element.attributes.get(name)
    return element.place if attribute is None else attribute.value_place


def entries_of(node: Node, *, written: bool) -> list[EntryName]:
    """Return the entries that the ports of a node write, or those that they only read."""
    keys = [node.key_of(name) for name, port in node.ports.items() if port.writes is written]
    return [variable_of(node.scope, key) for key in keys if key]


def scripts_of(node: Node) -> Mapping[str, ParsedScript]:
    """Return the scripts of a node by attribute, those around its tick and that of its port."""
    guard = node._node_guard
    scripts = {} if guard is None else guard.scripts
    if isinstance(node, ScriptPort) and (script := script_of(node)):
        return {**scripts, node.checked_port: script}
    return scripts


def script_of(node: ScriptPort) -> ParsedScript | None:
    """Return the script in a node's port; None if it is read from an entry, or invalid."""
    text = node.given.get(node.checked_port)
    if not isinstance(text, str) or is_pointer(text):
        return None
    try:
        return node.parsed(text)
    except ScriptError:
        return None  # reported where the node was made


def constant_truth(script: ParsedScript | None, node: Node) -> bool | None:
    """Return whether a condition without variables holds; None if that depends on the run."""
    enums = node.runtime.enums
    if script is None or script.reads - enums.keys() or script.writes:
        return None
    try:
        return is_true(script.evaluate(Environment(Blackboard(), enums)))
    except BtManipError:
        return None
