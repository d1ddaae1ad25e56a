"""A walk through a tree over all ways at once: which statuses and facts are possible at each node.

Each node is visited with the facts that hold on some way that leads to it, and answers with the
facts for each status that its tick can have. Loops are walked until nothing new is found: facts
only ever grow, so the walk ends.
"""

from collections.abc import Hashable, Mapping, Set
from typing import Any, Final, NamedTuple

from bt_manip.bt.analysis.facts import (
    COMPLETE,
    ENDED,
    UNWRITTEN,
    WRITTEN,
    Constant,
    EntryName,
    Fact,
    Facts,
    Values,
    Way,
    Ways,
    constant_in,
    either,
    join,
    values_of,
    variable_of,
    written,
)
from bt_manip.bt.analysis.flows import FLOWS
from bt_manip.bt.analysis.uses import ROBOT, constant_truth, entries_of, script_of
from bt_manip.bt.blackboard import EMPTY, Blackboard
from bt_manip.bt.nodes.action import Condition, Leaf, SyncAction
from bt_manip.bt.nodes.actions.blackboard import SetBlackboard, UnsetBlackboard, Watching
from bt_manip.bt.nodes.actions.script import Script, ScriptCondition
from bt_manip.bt.nodes.actions.sleep import Sleep
from bt_manip.bt.nodes.guard import GUARDS
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.tree_node import TreeNode
from bt_manip.bt.port_types import STRING
from bt_manip.bt.ports import is_pointer
from bt_manip.bt.script.evaluation import Environment, is_true
from bt_manip.bt.script.parser import ParsedScript
from bt_manip.bt.status import FAILURE, RUNNING, SKIPPED, SUCCESS
from bt_manip.bt.traits import UNDECLARED, YES_OR_NO, Traits
from bt_manip.exceptions import BtManipError

_NO_ENTRY: Final = "does not exist"


class ScriptFailure(NamedTuple):
    """How a script fails: its attribute, the error, and the entries that it lacks."""

    name: str
    error: str
    lacks: Set[EntryName]


class Walk:
    """The walk through one bound tree, with the values of the `followed` entries.

    Attributes, all by the identity of a node:
        incoming: What may hold when it is ticked; missing if it never is.
        ways: What it can answer.
        errors: How a script of it always fails.
        barred: Why it never runs: the reason, which holds only where nothing is incoming, or the
            script in front of it that always decides for it.
    """

    def __init__(self, followed: Set[EntryName]) -> None:
        self._followed = followed
        self.incoming: dict[int, Facts] = {}
        self.ways: dict[int, Ways] = {}
        self.errors: dict[int, ScriptFailure] = {}
        self.barred: dict[int, tuple[str, str]] = {}

    def visit(self, node: TreeNode, facts: Facts) -> Ways:
        """Return the ways of a node that is ticked with these facts, among others."""
        key = id(node)
        known = self.incoming.get(key, facts)
        facts = join(known, facts)
        if known is not facts or key not in self.ways:
            self.incoming[key] = facts
            self.errors.pop(key, None)
            self.ways[key] = self._guarded(node, facts)
        return self.ways[key]

    def bar(self, node: TreeNode, reason: str) -> None:
        """Note why a node is not reached, unless it is on another way."""
        self.barred.setdefault(id(node), (reason, ""))

    def number(self, node: Node, port: str) -> float | None:
        """Return the number that a port reads on every way; None if there is no such number."""
        one = constant_in(port_values(node, port, self.incoming[id(node)]))
        try:
            return None if one is None else float(one.value)
        except ValueError:
            return None

    # ------------------------------------------------------------------ scripts

    def _guarded(self, node: TreeNode, facts: Facts) -> Ways:
        guard = getattr(node, "_node_guard", None)
        if guard is None or not guard.scripts:
            return self._ticked(node, facts)
        assert isinstance(node, Node)
        scripts = guard.scripts
        early: Ways = {}
        for name, (status, decisive) in GUARDS.items():
            if name in scripts:
                facts = self._run(scripts[name], node, name, facts)
                truth = constant_truth(scripts[name], node)
                if truth is None or truth is decisive:
                    early = either(early, {status: Way(facts)})
                if truth is decisive:
                    reason = (
                        f"its {name} {'always' if decisive else 'never'} holds; remove the node"
                    )
                    self.barred[id(node)] = f"{reason}, or let the script read an entry", name
                    return early
        ways = dict(self._ticked(node, facts))
        if "_while" in scripts and RUNNING in ways:
            early = either(early, {SKIPPED: Way(ways[RUNNING].facts)})
        for status, names in (
            (SUCCESS, ("_onSuccess", "_post")),
            (FAILURE, ("_onFailure", "_post")),
            (RUNNING, ("_onHalted",)),
        ):
            for name in names:
                if status in ways and (script := scripts.get(name)):
                    before, time = ways[status]
                    after = self._run(script, node, name, before)
                    ways[status] = Way(join(before, after) if status is RUNNING else after, time)
        return either(early, ways)

    def _run(self, script: ParsedScript, node: Node, name: str, facts: Facts) -> Facts:
        """Return the facts after a script of a node's attribute; note if it always fails.

        It is evaluated if all that it reads is constant, with the types of entries that ports
        declare. The run ends where it fails.
        """
        scope, enums = node.scope, node.runtime.enums
        variables = {key: variable_of(scope, key) for key in script.writes}
        scratch = Blackboard()
        is_known, missing = True, set()
        for key in (script.reads | script.writes) - enums.keys():
            entry, values = scope.entry(key), values_of(facts, variable_of(scope, key))
            mine = key.lstrip("@")
            if entry is not None and entry.declared.strong:
                scratch.declare(mine, entry.declared)
            if values == {UNWRITTEN}:
                if key not in script.writes:
                    is_known, facts = False, {**facts, **ENDED}
                missing.add(variable_of(scope, key))
            elif (value := constant_in(values)) is not None:
                scratch.declare(mine).put(value.value, value.type)
            else:
                is_known = False
        results: dict[EntryName, Constant | None] = dict.fromkeys(variables.values())
        if is_known:
            try:
                result = script.evaluate(Environment(scratch, enums))
                if name in GUARDS or isinstance(node, ScriptCondition):
                    is_true(result)
            except BtManipError as error:
                if _NO_ENTRY not in str(error):
                    missing = set()
                self.errors[id(node)] = ScriptFailure(name, str(error), missing)
                return {**self._written(facts, results), **ENDED}
            for key, variable in variables.items():
                entry = scratch.entry(key.lstrip("@"))
                if entry is not None and entry.value is not EMPTY:
                    results[variable] = Constant(entry.value, entry.type)
        return self._written(facts, results)

    def _written(self, facts: Facts, values: Mapping[EntryName, Constant | None]) -> Facts:
        return written(facts, {k: v for k, v in values.items() if k in self._followed})

    # ------------------------------------------------------------------ nodes

    def _ticked(self, node: TreeNode, facts: Facts) -> Ways:
        if isinstance(node, Leaf):
            return self._leaf(node, facts)
        flow = FLOWS.get(getattr(type(node), "_tick", None))
        if flow is not None:
            return flow(self, node, facts)
        if isinstance(node, Node):
            facts = self._written(facts, dict.fromkeys(entries_of(node, written=True)))
        facts = self.in_any_order(node.child_nodes, facts)
        return dict.fromkeys((*COMPLETE, RUNNING), Way(facts))

    def in_any_order(self, children: list[Any], facts: Facts) -> Facts:
        """Visit children that can be ticked in any order, any number of times."""
        while True:
            after = facts
            for child in children:
                for way in self.visit(child, after).values():
                    after = join(after, way.facts)
            if after is facts:
                return facts
            facts = after

    def _leaf(self, node: Leaf, facts: Facts) -> Ways:
        traits, time = traits_of(node), 0.0
        if traits is not UNDECLARED and not isinstance(node, SetBlackboard | Watching):
            if any(
                values_of(facts, entry) == {UNWRITTEN} for entry in entries_of(node, written=False)
            ):
                facts = {**facts, **ENDED}
        after, statuses = self._effects(node, facts), traits.returns
        if isinstance(node, ScriptCondition):
            truth = constant_truth(script_of(node), node)
            if truth is not None:
                statuses = frozenset({SUCCESS if truth else FAILURE})
        elif isinstance(node, Sleep):
            time = self.number(node, "msec") or 0.0
        robot = robot_of(node, facts)
        succeeded = _with_facts(after, robot, traits.leaves)
        otherwise = join(facts, _with_facts(after, robot, dict.fromkeys(traits.leaves)))
        if traits is UNDECLARED and not isinstance(node, SyncAction):  # it may do anything
            entries = (one for one in otherwise if isinstance(one, EntryName))
            succeeded = otherwise = {entry: otherwise[entry] for entry in entries}
        ways = dict.fromkeys((FAILURE, SKIPPED), Way(otherwise))
        ways |= {SUCCESS: Way(succeeded, time), RUNNING: Way(join(otherwise, succeeded))}
        return {status: way for status, way in ways.items() if status in statuses}

    def _effects(self, node: Leaf, facts: Facts) -> Facts:
        """Return the facts about entries after a leaf has done its work."""
        if isinstance(node, Script | ScriptCondition):
            script = script_of(node)
            return facts if script is None else self._run(script, node, node.checked_port, facts)
        if isinstance(node, UnsetBlackboard):
            key = node.port_text("key")
            entry = EntryName(id(node.scope), key or "")
            return {**facts, entry: frozenset({UNWRITTEN})} if entry in self._followed else facts
        if not isinstance(node, SetBlackboard):
            return self._written(facts, dict.fromkeys(entries_of(node, written=True)))
        key, text = node.port_text("output_key"), node.port_text("value")
        if not key or text is None:
            return facts
        if is_pointer(key):  # any entry
            return {**facts, **{one: values_of(facts, one) | {WRITTEN} for one in self._followed}}
        value = None if is_pointer(text) else Constant(text, STRING)
        return self._written(facts, {variable_of(node.scope, key): value})


def traits_of(node: TreeNode) -> Traits:
    """Return the traits of a leaf: its own, or those of its kind."""
    traits: Traits | None = getattr(node, "traits", None)
    return traits or (YES_OR_NO if isinstance(node, Condition) else UNDECLARED)


def port_values(node: Node, port: str, facts: Facts) -> Values:
    """Return the possible values that a port reads: its text, or those of its entry."""
    key, text = node.key_of(port), node.port_text(port)
    if key is not None:
        return values_of(facts, variable_of(node.scope, key))
    return frozenset({UNWRITTEN if text is None else Constant(text, STRING)})


def robot_of(node: TreeNode, facts: Facts) -> Hashable:
    """Return the robot of a leaf: its name, the variable that holds it, or an empty text.

    Two robots differ for certain only if both have names.
    """
    if not isinstance(node, Node) or ROBOT not in node.ports:
        return ""
    text = node.port_text(ROBOT)
    key = node.key_of(ROBOT) if text else ROBOT
    if key is None:
        return text
    variable = variable_of(node.scope, key)
    values = values_of(facts, variable)
    if (value := constant_in(values)) is not None:
        return str(value.value)
    return "" if not text and values == {UNWRITTEN} else variable


def _with_facts(facts: Facts, robot: Hashable, leaves: Mapping[str, bool | None]) -> Facts:
    """Return the facts after a leaf left some of its robot, and perhaps of another name of it."""
    if not leaves:
        return facts
    changed = dict(facts)
    for one in facts:
        if type(one) is Fact and one.name in leaves:
            names = {one.robot, robot}
            if len(names) == 1 or "" in names or not all(isinstance(name, str) for name in names):
                del changed[one]
    known = ((name, value) for name, value in leaves.items() if value is not None)
    return changed | {Fact(robot, name): frozenset({value}) for name, value in known}
