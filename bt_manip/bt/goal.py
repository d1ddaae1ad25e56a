"""The goal of a tree: conditions on the cell that hold when the tree has done its task."""

import re
import shlex
from collections.abc import Container, Iterable, Mapping
from typing import Any, Final

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import Blackboard, Entry
from bt_manip.bt.nodes.binding import OnProblem, bind
from bt_manip.bt.nodes.node import Node, NodeKind
from bt_manip.bt.port_types import UNTYPED, PortType
from bt_manip.bt.ports import Port
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.runtime import Runtime
from bt_manip.bt.status import SUCCESS
from bt_manip.exceptions import BtManipError, TreeError, did_you_mean, shown

GOAL: Final = "_goal"
"""Attribute of a ``<BehaviorTree>`` that declares its goal."""

TASK: Final = "_task"
"""Attribute of a ``<BehaviorTree>`` with its task as a sentence, for data sets."""

RESULT_KEYS: Final = "_results"
"""Attribute of a ``<BehaviorTree>`` with the keys of its results, separated by spaces."""

CONTINUES: Final = "_continues"
"""Attribute of a ``<BehaviorTree>``: ``true`` if a cycle begins where the one before ended."""

NO_CELL: Final = (
    "no condition of the goal reads the cell, so the tree alone decides whether it succeeded; "
    "add a condition on the cell, such as IsIn"
)
"""The warning for a goal that `reads_cell` does not hold for."""

MAX_GOAL: Final = 2**16
"""Maximum number of characters of a goal."""

AND: Final = "&&"
"""Joins the conditions of a goal."""


class _ReadOnlyScope(Blackboard):
    """A scope with the entries of another one, in which conditions declare nothing."""

    def __init__(self, scope: Blackboard) -> None:
        super().__init__(scope)
        self.autoremap = True

    def entry(self, key: str) -> Entry | None:
        """Find the entry behind a key."""
        assert self.parent is not None
        return self.parent.entry(key)

    def declare(self, key: str, type: PortType = UNTYPED) -> Entry:
        """Return an entry that nothing else sees."""
        return Entry(type)

    def write(self, key: str, value: Any, type: PortType) -> None:
        """Write nothing."""


def declarations(attributes: Mapping[str, str]) -> dict[str, Any]:
    """Return the declarations in the attributes of a ``<BehaviorTree>``, as arguments of `Tree`.

    Raises:
        TreeError: If one has no such form.
    """
    results = attributes.get(RESULT_KEYS, "").split()
    for key in results:
        if not re.fullmatch(r"[^\W\d][\w.-]*", key):
            raise TreeError(
                f"{RESULT_KEYS}: expected keys separated by spaces, such as 'left right', "
                f"got {shown(key)}"
            )
    continues = attributes.get(CONTINUES, "false")
    if continues not in ("true", "false"):
        raise TreeError(f"{CONTINUES}: expected 'true' or 'false', got {shown(continues)}")
    return {
        "task": attributes.get(TASK, ""), "results": results, "continues": continues == "true",
    }  # fmt: skip


def parse_goal(text: str, registry: BehaviourRegistry) -> tuple[Node, ...]:
    """Return the conditions of a goal.

    Args:
        text: Conditions joined by ``&&``, each a registered name followed by ``port=value``; values
            with spaces are quoted.
        registry: The behaviours that it may name.

    Raises:
        TreeError: If the text is malformed or names an unknown condition or port.
    """
    if len(text) > MAX_GOAL:
        raise TreeError(f"the goal is longer than {MAX_GOAL} characters")
    try:
        words = [*shlex.split(text), AND]
    except ValueError as error:
        raise TreeError(f"the goal {shown(text)} cannot be read: {error}") from None
    conditions: list[Node] = []
    while words:
        end = words.index(AND)
        conditions.append(_condition(words[:end], registry))
        words = words[end + 1 :]
    return tuple(conditions)


def _condition(words: list[str], registry: BehaviourRegistry) -> Node:
    if not words:
        raise TreeError(f"expected conditions joined by '{AND}', such as NAME port=value")
    name, *assignments = words
    known = [n for n in registry.names() if registry.get(n).kind is NodeKind.CONDITION]
    if name not in known:
        raise TreeError(f"no condition is named '{name}'" + did_you_mean(name, known))
    cls = registry.get(name)
    given: dict[str, str] = {}
    for word in assignments:
        port, equals, value = word.partition("=")
        if not equals or port in given:
            raise TreeError(f"{name}: expected one port=value for each port, got '{word}'")
        if port not in cls.ports:
            raise TreeError(f"{name} has no port '{port}'" + did_you_mean(port, cls.ports))
        given[port] = value
    _check_mandatory(name, cls.ports, given)
    try:
        condition = cls(**given)
    except BtManipError as error:
        raise TreeError(str(error)) from error
    condition.registration = name
    return condition


def _check_mandatory(name: str, ports: Mapping[str, Port], given: Container[str]) -> None:
    for port, declared in ports.items():
        if declared.mandatory and port not in given:
            raise TreeError(f"{name} needs the port '{port}'")


def goal_to_text(goal: Iterable[Node], registry: BehaviourRegistry) -> str:
    """Write the conditions of a goal, of registered classes, as the text that `parse_goal` reads.

    Raises:
        TreeError: If the class of a condition is not registered.
        PortError: If a value has no form as text.
    """
    parts = []
    for condition in goal:
        name = registry.name_of(type(condition))
        if name is None:
            raise TreeError(f"the goal's {type(condition).__name__} is not registered")
        ports = [f"{port}={_quoted(condition.port_text(port) or '')}" for port in condition.given]
        parts.append(" ".join([name, *ports]))
    return f" {AND} ".join(parts)


def _quoted(value: str) -> str:
    plain = value.split() == [value] and not set(value) & set("'\"\\")
    return value if plain else shlex.quote(value)


def bind_goal(
    goal: Node | Iterable[Node], scope: Blackboard, runtime: Runtime, on_problem: OnProblem | None
) -> tuple[Node, ...]:
    """Bind the conditions of a goal to a scope, which they only read; `on_problem` as of `bind`.

    Raises:
        TreeError: If one is no condition.
    """
    conditions = (goal,) if isinstance(goal, Node) else tuple(goal)
    own = Runtime(lambda: runtime.clock())
    own.enums = runtime.enums
    for condition in conditions:
        if not isinstance(condition, Node) or condition.kind is not NodeKind.CONDITION:
            raise TreeError(f"a goal consists of conditions, got {type(condition).__name__}")
        _check_mandatory(condition.name, condition.ports, condition.given)
        bind(condition, own, _ReadOnlyScope(scope), on_problem)
        condition.path = f"goal/{condition.name}"
    return conditions


def reads_cell(goal: Iterable[Node]) -> bool:
    """Return whether a condition of a goal can read the cell, and not only the tree's blackboard.

    A condition gets the cell, as all infrastructure, in its ``setup``; one that inherits
    py_trees' own, such as ``ScriptCondition``, has only its ports and the blackboard.
    """
    return any(type(condition).setup is not Behaviour.setup for condition in goal)


def why_not_met(condition: Node) -> str:
    """Return why a condition of a goal does not hold; empty if it does.

    A condition that cannot be evaluated does not hold.
    """
    try:
        if condition.execute() is SUCCESS:
            return ""
        return condition.feedback_message or f"{condition.name} does not hold"
    except Exception as error:  # a plugin's condition may raise anything
        cause = error.__cause__ or error
        return str(cause) or type(cause).__name__
    finally:
        condition._reset()


def texts_of(condition: Node) -> list[str]:
    """Return the present values of a condition's ports that are texts, such as names, in order."""
    texts = []
    for port in condition.ports:
        try:
            value = condition.read_port(port)
        except BtManipError:
            continue
        if isinstance(value, str):
            texts.append(value)
    return texts
