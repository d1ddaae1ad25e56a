"""Static checks of our own: errors that the engine reports only at run time, and warnings."""

from collections.abc import Iterable, Mapping
from typing import Any, Final

from bt_manip.bt.blackboard import EMPTY, Blackboard
from bt_manip.bt.goal import GOAL, TASK
from bt_manip.bt.literals import parse_integer
from bt_manip.bt.nodes.actions.blackboard import SetBlackboard, Watching
from bt_manip.bt.nodes.actions.script import ScriptPort
from bt_manip.bt.nodes.controls.branching import IfThenElse, WhileDoElse
from bt_manip.bt.nodes.controls.parallel import Parallel, ParallelAll, threshold
from bt_manip.bt.nodes.controls.switch import Switch2, Switch3, Switch4, Switch5, Switch6
from bt_manip.bt.nodes.node import CONDITIONS, Node
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.ports import is_pointer, pointed_key
from bt_manip.bt.script.parser import ParsedScript, parse_script
from bt_manip.bt.xml.dialect import Dialect
from bt_manip.bt.xml.document import Document
from bt_manip.bt.xml.problem import Place, Problems
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import ScriptError, did_you_mean, shortened

_BRANCHING: Final = (IfThenElse, WhileDoElse)
_SWITCHES: Final = (Switch2, Switch3, Switch4, Switch5, Switch6)


def check_attributes(element: Element, problems: Problems, dialect: Dialect) -> None:
    """Warn of attributes of an element that have no meaning, or that are not well-formed XML."""
    scripts = tuple(CONDITIONS.values())
    for name, attribute in element.attributes.items():
        if not attribute.well_formed:
            problems.warning(
                attribute.value_place,
                "other XML readers refuse '&' and '<' here; write '&amp;' and '&lt;'",
            )
        if name in (GOAL, TASK) and element.name == "BehaviorTree":
            continue
        if name.startswith("_") and name not in scripts and not dialect.knows(name):
            hint = did_you_mean(name, [*scripts, "_autoremap"])
            if not hint.startswith("; did"):
                hint = ""
            problems.warning(attribute.place, f"the attribute '{name}' has no meaning{hint}")
        if name == "_autoremap" and element.name not in ("SubTree", "BehaviorTree"):
            problems.warning(attribute.place, "only a <SubTree> has '_autoremap'")


def check_node(element: Element, name: str, cls: type[Node], problems: Problems) -> None:
    """Check that a node has its mandatory ports and the children that it needs."""
    for port in cls.ports.values():
        if port.mandatory and port.name not in element.attributes:
            doc = f" ({port.doc})" if port.doc else ""
            problems.error(
                element.place, f"{name} needs the port '{port.name}' of type {port.type.name}{doc}"
            )
    count = len(element.children)
    if issubclass(cls, _BRANCHING) and count not in (0, 2, 3):
        problems.error(
            element.place, f"{name} must have 2 or 3 children: a condition and 1 or 2 branches"
        )
    elif issubclass(cls, _SWITCHES) and count not in (0, cls.most_children):
        problems.error(
            element.place,
            f"{name} must have {cls.most_children} children, one for each case and one for all "
            f"others; it has {count}",
        )
    elif issubclass(cls, Parallel | ParallelAll):
        _check_thresholds(element, name, cls, count, problems)


def _check_thresholds(
    element: Element, name: str, cls: type[Node], count: int, problems: Problems
) -> None:
    for port in cls.ports.values():
        text = element.get(port.name)
        if text is None or is_pointer(text) or count == 0:
            continue
        try:
            wanted = parse_integer(text)
        except ValueError:
            continue  # reported as a literal of the wrong type
        if threshold(wanted, count) > count:
            problems.error(
                element.place_of(port.name),
                f"{name} has {count} children: {port.name}={wanted} can never be reached",
            )


def check_unused(
    document: Document, main: str, built: Mapping[str, None], problems: Problems
) -> None:
    """Warn of the trees that the main tree does not reach."""
    for tree_id, element in document.trees.items():
        if tree_id not in built and element.place.file == document.file:
            problems.warning(
                element.place_of("ID"), f"nothing uses the tree '{tree_id}' ({main} runs)"
            )


def check_goals_below(
    document: Document, main: str, built: Iterable[str], problems: Problems
) -> None:
    """Warn of goals of sub-trees, which are ignored, where the main tree has none."""
    if GOAL in document.trees[main].attributes:
        return
    for subtree in (document.trees[name] for name in built):
        if GOAL in subtree.attributes:
            problems.warning(
                subtree.place_of(GOAL),
                f"the '{GOAL}' of a sub-tree is ignored; main tree '{main}' has none",
            )


def check_keys(
    nodes: list[Any], places: Mapping[int, Element], problems: Problems, given: Iterable[str] = ()
) -> None:
    """Warn of blackboard keys that are read and that nothing writes.

    Args:
        nodes: The nodes of a bound tree.
        places: The elements of the nodes.
        problems: Takes the warnings.
        given: Keys of the root that are written before the tree runs.
    """
    written: set[tuple[int, str]] = set()
    if nodes and isinstance(nodes[0], Node):
        written.update((id(nodes[0].scope), key) for key in given)
    read: list[tuple[tuple[int, str], str, Place]] = []
    for node in nodes:
        element = places.get(id(node))
        if not isinstance(node, Node) or element is None:
            continue
        for key, place in _ports_read(node, element):
            read.append((_owner(node.scope, key), key, place))
        for key in _ports_written(node):
            written.add(_owner(node.scope, key))
        for script, place in _scripts(node, element):
            for key in script.writes:
                written.add(_owner(node.scope, key))
            for key in script.reads - script.writes:
                if key not in node.runtime.enums:
                    read.append((_owner(node.scope, key), key, place))
        if isinstance(node, SubTree):
            written.update(
                (id(node.inner_scope), key)
                for key, entry in node.inner_scope.entries.items()
                if entry.value is not EMPTY
            )
    scopes = {id(node.scope): node.scope for node in nodes if isinstance(node, Node)}
    for owner, key, place in read:
        entry = scopes[owner[0]].entries.get(owner[1]) if owner[0] in scopes else None
        if owner not in written and (entry is None or entry.value is EMPTY):
            name = shortened(key)
            problems.warning(
                place, f"nothing writes the blackboard entry '{name}' that is read here"
            )


def _ports_read(node: Node, element: Element) -> list[tuple[str, Place]]:
    keys = []
    for name, port in node.ports.items():
        text = node.port_text(name)
        key = pointed_key(name, text) if text is not None else None
        if key is not None and port.reads and not (port.writes or isinstance(node, Watching)):
            attribute = element.attributes.get(name)
            keys.append((key, element.place if attribute is None else attribute.value_place))
    return keys


def _ports_written(node: Node) -> list[str]:
    keys = []
    for name, port in node.ports.items():
        text = node.given.get(name, port.default)
        key = pointed_key(name, text) if port.writes and isinstance(text, str) else None
        if key is not None:
            keys.append(key)
        elif isinstance(node, SetBlackboard) and name == "output_key" and isinstance(text, str):
            keys.append(text)
    return keys


def _scripts(node: Node, element: Element) -> list[tuple[ParsedScript, Place]]:
    scripts = []
    names = list(node.conditions)
    if isinstance(node, ScriptPort):
        names.append(node.checked_port)
    for name in names:
        text = node.conditions.get(name) or str(node.given.get(name, ""))
        attribute = element.attributes.get(name)
        if attribute is not None and text and not is_pointer(text):
            try:
                scripts.append((parse_script(text, double_quotes=True), attribute.value_place))
            except ScriptError:
                continue  # reported where the node was made
    return scripts


def _owner(scope: Blackboard, key: str) -> tuple[int, str]:
    owner, own_key = scope.place(key)
    return id(owner), own_key
