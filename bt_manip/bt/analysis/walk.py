"""A walk through a tree over all ways at once: which statuses and facts are possible at each node.

Each node is visited with the facts that hold on some way that leads to it, and answers with the
facts for each status that its tick can have. Loops are walked until nothing new is found: facts
only ever grow, so the walk ends.
"""

from collections.abc import Callable, Hashable, Mapping, Set
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from bt_manip.bt.analysis.facts import (
    UNWRITTEN,
    WRITTEN,
    Constant,
    EntryName,
    Fact,
    Facts,
    join,
    values_of,
    variable_of,
    written,
)
from bt_manip.bt.blackboard import EMPTY, Blackboard
from bt_manip.bt.nodes.action import Condition, Leaf, SyncAction
from bt_manip.bt.nodes.actions.blackboard import SetBlackboard, UnsetBlackboard
from bt_manip.bt.nodes.actions.script import Script, ScriptCondition
from bt_manip.bt.nodes.actions.sleep import Sleep
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.tree_node import TreeNode
from bt_manip.bt.port_types import STRING
from bt_manip.bt.ports import is_pointer, pointed_key
from bt_manip.bt.script.evaluation import Environment, is_true
from bt_manip.bt.script.parser import ParsedScript, parse_script
from bt_manip.bt.status import FAILURE, RUNNING, SKIPPED, SUCCESS, NodeStatus
from bt_manip.bt.traits import UNDECLARED, YES_OR_NO, Traits
from bt_manip.exceptions import BtManipError, ScriptError

_NO_ENTRY: Final = "does not exist"  # others than the tree may write it before

COMPLETE: Final = (SUCCESS, FAILURE, SKIPPED)


class Way(NamedTuple):
    """One way to a status.

    Attributes:
        facts: What holds then.
        least: The shortest time that it takes [ms].
    """

    facts: Facts
    least: float = 0.0


@dataclass(frozen=True)
class Outcomes:
    """What a node can answer: for each status the ways to it, or None if it is impossible.

    Attributes:
        success: The ways to SUCCESS.
        failure: The ways to FAILURE.
        skipped: The ways to SKIPPED.
        running: The facts while it runs, or is halted; None if it completes within a tick.
    """

    success: Way | None = None
    failure: Way | None = None
    skipped: Way | None = None
    running: Facts | None = None

    def of(self, status: NodeStatus) -> Way | None:
        """Return the ways to a status that completes the node."""
        return {SUCCESS: self.success, FAILURE: self.failure, SKIPPED: self.skipped}[status]

    @property
    def least(self) -> float:
        """The shortest time until the node completes [ms]; infinite if it never does."""
        ways = [way.least for way in map(self.of, COMPLETE) if way is not None]
        return min(ways, default=float("inf"))

    @property
    def facts(self) -> Facts | None:
        """What may hold after some tick of the node; None if nothing is possible."""
        found = self.running
        for way in map(self.of, COMPLETE):
            if way is not None:
                found = join(found, way.facts)
        return found


def either(first: Way | None, second: Way | None, after: float = 0.0) -> Way | None:
    """Return the ways of both; the second ones begin `after` [ms]."""
    if second is None:
        return first
    least = second.least + after
    if first is None:
        return Way(second.facts, least)
    return Way(join(first.facts, second.facts), min(first.least, least))


Flow = Callable[["Walk", Any, Facts], Outcomes]
"""Gives the outcomes of a node with children."""


class Walk:
    """The walk through one bound tree.

    Args:
        flows: The flow of each kind of node with children, by the function of its tick.
        followed: The entries of the blackboard whose values are followed.

    Attributes:
        incoming: What may hold when a node is ticked, by its identity; missing if it never is.
        outcomes: What a node can answer, by its identity.
        decided: The script in front of a node that always decides for it, by its identity.
        errors: A script that always fails: the attribute and the reason, by the node's identity.
        barred: Why a node is never reached, by its identity, if it is not.
    """

    def __init__(self, flows: dict[Any, Flow], followed: Set[EntryName] = frozenset()) -> None:
        self._flows = flows
        self._followed = followed
        self.incoming: dict[int, Facts] = {}
        self.outcomes: dict[int, Outcomes] = {}
        self.decided: dict[int, str] = {}
        self.errors: dict[int, tuple[str, str]] = {}
        self.barred: dict[int, str] = {}

    def visit(self, node: TreeNode, facts: Facts) -> Outcomes:
        """Return the outcomes of a node that is ticked with these facts, among others."""
        key = id(node)
        known = self.incoming.get(key)
        facts = join(known, facts)
        if known is facts and key in self.outcomes:
            return self.outcomes[key]
        self.incoming[key] = facts
        outcomes = self._guarded(node, facts)
        self.outcomes[key] = outcomes
        return outcomes

    # ------------------------------------------------------------------ scripts around a tick

    def _guarded(self, node: TreeNode, facts: Facts) -> Outcomes:
        guard = getattr(node, "_node_guard", None)
        scripts = {} if guard is None else guard.scripts
        if not scripts:
            return self._ticked(node, facts)
        assert isinstance(node, Node)
        early: dict[NodeStatus, Way | None] = dict.fromkeys(COMPLETE)
        for name, status in (
            ("_failureIf", FAILURE),
            ("_successIf", SUCCESS),
            ("_skipIf", SKIPPED),
            ("_while", SKIPPED),
        ):
            truth = constant_truth(scripts.get(name), node) if name in scripts else False
            if name == "_while" and name in scripts and truth is not None:
                truth = not truth
            if truth is not False:
                early[status] = either(early[status], Way(facts))
            if truth:
                self.decided[id(node)] = name
                return Outcomes(early[SUCCESS], early[FAILURE], early[SKIPPED])
        inner = self._ticked(node, facts)
        if "_while" in scripts and inner.running is not None:
            early[SKIPPED] = either(early[SKIPPED], Way(inner.running))
        success, failure = inner.success, inner.failure
        for name in ("_onSuccess", "_post"):
            success = self._after(success, name, scripts.get(name), node)
        for name in ("_onFailure", "_post"):
            failure = self._after(failure, name, scripts.get(name), node)
        running = inner.running
        if running is not None and "_onHalted" in scripts:
            running = join(running, self.run_script(scripts["_onHalted"], node, running)[0])
        return Outcomes(
            either(early[SUCCESS], success),
            either(early[FAILURE], failure),
            either(early[SKIPPED], inner.skipped),
            running,
        )

    def _after(
        self, way: Way | None, name: str, script: ParsedScript | None, node: Node
    ) -> Way | None:
        if way is None or script is None:
            return way
        facts, error = self.run_script(script, node, way.facts)
        if error:
            self.errors[id(node)] = name, error
        return Way(facts, way.least)

    def run_script(self, script: ParsedScript, node: Node, facts: Facts) -> tuple[Facts, str]:
        """Return the facts after a script, and why it always fails, or an empty text.

        It is evaluated if all that it reads is constant; the entries that it writes have the types
        that the ports of the tree declare.
        """
        scope, enums = node.scope, node.runtime.enums
        variables = {key: variable_of(scope, key) for key in script.writes}
        scratch = Blackboard()
        known, is_missing = True, False
        for key in (script.reads | script.writes) - enums.keys():
            variable = variables.get(key) or variable_of(scope, key)
            entry, values = scope.entry(key), values_of(facts, variable)
            name = key.lstrip("@")
            if entry is not None and entry.declared.strong:
                scratch.declare(name, entry.declared)
            if values == {UNWRITTEN}:
                known &= key in script.writes
                is_missing = True
            elif len(values) == 1 and isinstance(value := next(iter(values)), Constant):
                scratch.declare(name).put(value.value, value.type)
            else:
                known = False
        if not known:
            return self._written(facts, dict.fromkeys(variables.values())), ""
        try:
            script.evaluate(Environment(scratch, enums))
        except BtManipError as error:
            after = self._written(facts, dict.fromkeys(variables.values()))
            return after, "" if is_missing and _NO_ENTRY in str(error) else str(error)
        results: dict[EntryName, Constant | None] = {}
        for key, variable in variables.items():
            entry = scratch.entry(key.lstrip("@"))
            if entry is not None and entry.value is not EMPTY:
                results[variable] = Constant(entry.value, entry.type)
            else:
                results[variable] = None
        return self._written(facts, results), ""

    # ------------------------------------------------------------------ nodes

    def _ticked(self, node: TreeNode, facts: Facts) -> Outcomes:
        if isinstance(node, Leaf):
            return self._leaf(node, facts)
        flow = self._flows.get(getattr(type(node), "_tick", None))
        return self._any_way(node, facts) if flow is None else flow(self, node, facts)

    def _any_way(self, node: TreeNode, facts: Facts) -> Outcomes:
        """Return the outcomes of a node of which nothing is known: children in any order."""
        if isinstance(node, Node):
            facts = self._written(facts, dict.fromkeys(_outputs(node)))
        facts = self.in_any_order(node.child_nodes, facts)
        way = Way(facts)
        return Outcomes(way, way, way, facts)

    def in_any_order(self, children: list[Any], facts: Facts) -> Facts:
        """Visit children that can be ticked in any order, any number of times."""
        while True:
            after = facts
            for child in children:
                after = join(after, self.visit(child, after).facts)
            if after is facts:
                return facts
            facts = after

    def _leaf(self, node: Leaf, facts: Facts) -> Outcomes:
        traits = traits_of(node)
        after, least = self._effects(node, facts)
        statuses = traits.returns
        if isinstance(node, ScriptCondition):
            truth = constant_truth(script_of(node), node)
            if truth is not None:
                statuses = frozenset({SUCCESS if truth else FAILURE})
        if isinstance(node, Sleep):
            after, least = facts, literal(node, "msec") or 0.0
        robot = robot_of(node, facts)
        succeeded = _with_facts(after, robot, traits.leaves)
        perhaps = dict.fromkeys(traits.leaves)
        otherwise = join(facts, _with_facts(after, robot, perhaps))
        if node_is_open(node):
            succeeded = otherwise = {
                variable: values
                for variable, values in otherwise.items()
                if isinstance(variable, EntryName)
            }
        return Outcomes(
            Way(succeeded, least) if SUCCESS in statuses else None,
            Way(otherwise) if FAILURE in statuses else None,
            Way(otherwise) if SKIPPED in statuses else None,
            join(otherwise, succeeded) if RUNNING in statuses else None,
        )

    def _effects(self, node: Leaf, facts: Facts) -> tuple[Facts, float]:
        if isinstance(node, Script):
            script = script_of(node)
            if script is None:
                return facts, 0.0
            facts, error = self.run_script(script, node, facts)
            if error:
                self.errors[id(node)] = node.checked_port, error
            return facts, 0.0
        if isinstance(node, SetBlackboard):
            return self._set_entry(node, facts), 0.0
        if isinstance(node, UnsetBlackboard):
            key = node.port_text("key")
            if key and not is_pointer(key):
                entry = EntryName(id(node.scope), key)
                if entry in self._followed:
                    return {**facts, entry: frozenset({UNWRITTEN})}, 0.0
            return facts, 0.0
        return self._written(facts, dict.fromkeys(_outputs(node))), 0.0

    def _set_entry(self, node: SetBlackboard, facts: Facts) -> Facts:
        key = node.port_text("output_key")
        text = node.port_text("value")
        if not key or text is None:
            return facts
        if is_pointer(key):
            perhaps: dict[EntryName | Fact, Any] = {
                one: values_of(facts, one) | {WRITTEN} for one in self._followed
            }
            return {**facts, **perhaps}
        value = None if is_pointer(text) else Constant(text, STRING)
        return self._written(facts, {variable_of(node.scope, key): value})

    def _written(self, facts: Facts, values: Mapping[EntryName, Constant | None]) -> Facts:
        followed = {one: value for one, value in values.items() if one in self._followed}
        return written(facts, followed)


def node_is_open(node: TreeNode) -> bool:
    """Return whether a leaf may do anything to the cell: it declares nothing of itself."""
    return not isinstance(node, Condition | SyncAction) and getattr(node, "traits", None) is None


def traits_of(node: TreeNode) -> Traits:
    """Return the traits of a leaf: its own, or those of its kind."""
    traits: Traits | None = getattr(node, "traits", None)
    if traits is not None:
        return traits
    return YES_OR_NO if isinstance(node, Condition) else UNDECLARED


def robot_of(node: TreeNode, facts: Facts) -> Hashable:
    """Return the robot of a leaf: its name, the variable that holds it, or an empty text.

    Two robots differ for certain only if both have names.
    """
    if not isinstance(node, Node) or "robot" not in node.ports:
        return ""
    text = node.port_text("robot")
    if text and not is_pointer(text):
        return text
    key = pointed_key("robot", text) if text else "robot"
    variable = variable_of(node.scope, key or "robot")
    values = values_of(facts, variable)
    if len(values) == 1 and isinstance(value := next(iter(values)), Constant):
        return str(value.value)
    return "" if not text and values == {UNWRITTEN} else variable


def may_be_same(first: Hashable, second: Hashable) -> bool:
    """Return whether two robots, as `robot_of` gives them, may be the same one."""
    named = isinstance(first, str) and isinstance(second, str) and first and second
    return first == second or not named


def _with_facts(facts: Facts, robot: Hashable, leaves: Any) -> Facts:
    """Return the facts after a leaf left some of its robot."""
    if not leaves:
        return facts
    changed = dict(facts)
    for variable in facts:
        if isinstance(variable, Fact) and variable.name in leaves:
            if may_be_same(variable.robot, robot):
                del changed[variable]
    for name, value in leaves.items():
        if value is not None:
            changed[Fact(robot, name)] = frozenset({value})
    return changed


def _outputs(node: Node) -> list[EntryName]:
    """Return the entries that the ports of a node write."""
    found = []
    for name, port in node.ports.items():
        text = node.given.get(name, port.default)
        key = pointed_key(name, text) if port.writes and isinstance(text, str) else None
        if key is not None:
            found.append(variable_of(node.scope, key))
    return found


def script_of(node: Any) -> ParsedScript | None:
    """Return the script in a node's port; None if it is read from an entry, or invalid."""
    text = node.given.get(node.checked_port)
    if not isinstance(text, str) or is_pointer(text):
        return None
    try:
        return parse_script(text, double_quotes=node.double_quotes)
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


def literal(node: Node, port: str) -> float | None:
    """Return the number given for a port; None if it is read from an entry."""
    text = node.port_text(port)
    if text is None or is_pointer(text):
        return None
    try:
        return float(text)
    except ValueError:
        return None
