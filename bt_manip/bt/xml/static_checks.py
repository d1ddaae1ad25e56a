"""Static checks of our own: errors that the engine reports only at run time, and warnings."""

from collections.abc import Iterable, Mapping
from typing import Final

from bt_manip.bt.goal import CONTINUES, GOAL, RESULT_KEYS, TASK
from bt_manip.bt.literals import parse_integer
from bt_manip.bt.nodes.controls.branching import IfThenElse, WhileDoElse
from bt_manip.bt.nodes.controls.parallel import Parallel, ParallelAll, threshold
from bt_manip.bt.nodes.controls.switch import Switch
from bt_manip.bt.nodes.node import CONDITIONS, Node
from bt_manip.bt.ports import is_pointer
from bt_manip.bt.xml.dialect import Dialect
from bt_manip.bt.xml.document import Document
from bt_manip.bt.xml.problem import Problems
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import did_you_mean

_BRANCHING: Final = (IfThenElse, WhileDoElse)
_OF_A_TREE: Final = (GOAL, TASK, RESULT_KEYS, CONTINUES)


def check_attributes(element: Element, problems: Problems, dialect: Dialect) -> None:
    """Warn of attributes of an element that have no meaning, or that are not well-formed XML."""
    scripts = tuple(CONDITIONS.values())
    for name, attribute in element.attributes.items():
        if not attribute.well_formed:
            problems.warning(
                attribute.value_place,
                "other XML readers refuse '&' and '<' here; write '&amp;' and '&lt;'",
                "invalid-xml",
            )
        declared = _OF_A_TREE if element.name == "BehaviorTree" else ()
        if name in declared:
            continue
        is_meant = name.startswith("_") or f"_{name}" in declared
        if is_meant and name not in scripts and not dialect.knows(name):
            hint = did_you_mean(name, [*declared, *scripts, "_autoremap"])
            if not hint.startswith("; did"):
                hint = ""
            text = f"the attribute '{name}' has no meaning{hint}"
            problems.warning(attribute.place, text, "no-meaning")
        if name == "_autoremap" and element.name not in ("SubTree", "BehaviorTree"):
            text = "only a <SubTree> has '_autoremap'"
            problems.warning(attribute.place, text, "no-meaning")


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
    elif issubclass(cls, Switch) and count not in (0, cls.most_children):
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
                element.place_of("ID"),
                f"nothing uses the tree '{tree_id}' ({main} runs)",
                "unused-tree",
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
                "ignored-goal",
            )
