"""How facts flow through nodes that have children.

Each function mirrors the rules of one node's tick. Nodes without one can do anything, as far as the
checks know.
"""

from collections.abc import Callable, Mapping
from functools import partial, reduce
from typing import TYPE_CHECKING, Any, Final

from bt_manip.bt.analysis.facts import COMPLETE, Facts, Way, Ways, both, either, join, later, least
from bt_manip.bt.analysis.uses import constant_truth, script_of
from bt_manip.bt.nodes.controls.branching import IfThenElse, WhileDoElse
from bt_manip.bt.nodes.controls.parallel import Parallel, threshold
from bt_manip.bt.nodes.controls.reactive import ReactiveFallback, ReactiveSequence
from bt_manip.bt.nodes.controls.sequence import InOrder, SequenceWithMemory
from bt_manip.bt.nodes.controls.switch import Switch
from bt_manip.bt.nodes.controls.try_catch import TryCatch
from bt_manip.bt.nodes.decorators.conditional import Precondition
from bt_manip.bt.nodes.decorators.forcing import Inverter, KeepRunningUntilFailure
from bt_manip.bt.nodes.decorators.repeat import Counting
from bt_manip.bt.nodes.decorators.timing import Delay, Timeout
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.status import FAILURE, RUNNING, SKIPPED, SUCCESS, NodeStatus

if TYPE_CHECKING:
    from bt_manip.bt.analysis.walk import Walk


def _settled(flow: Callable[[Facts], Ways], facts: Facts, again: NodeStatus = RUNNING) -> Ways:
    """Return the ways of a node that is entered again with what holds after a status of it."""
    while True:
        ways = flow(facts)
        more = join(facts, ways[again].facts) if again in ways else facts
        if more is facts:
            return ways
        facts = more


def _renamed(ways: Ways, becomes: Mapping[NodeStatus, NodeStatus]) -> dict[NodeStatus, Way]:
    return either(*({becomes.get(status, status): way} for status, way in ways.items()))


def _in_order(walk: "Walk", children: list[Any], facts: Facts, goes_on: NodeStatus) -> Ways:
    """Return the ways of children of which the next is ticked after SKIPPED or `goes_on`."""
    ends = FAILURE if goes_on is SUCCESS else SUCCESS
    ended: Ways = {}
    way, passed = Way(facts), {goes_on: False, SKIPPED: True}
    for index, child in enumerate(children):
        ways = dict(later(walk.visit(child, way.facts), way.least))
        passed[goes_on] |= goes_on in ways
        passed[SKIPPED] &= SKIPPED in ways
        on = [ways.pop(one) for one in (goes_on, SKIPPED) if one in ways]
        ended = either(ended, ways)
        if not on:
            verb = f"always {'succeeds' if ends is SUCCESS else 'fails'}"
            reason = f"'{child.name}' before it {verb if ends in ways else 'never completes'}"
            for following in children[index + 1 : index + 2]:
                walk.bar(following, f"{reason}; remove it, or change their order")
            return ended
        way = reduce(both, on)
    return either(ended, {status: way for status, possible in passed.items() if possible})


def _sequence(walk: "Walk", node: InOrder, facts: Facts) -> Ways:
    if isinstance(node, SequenceWithMemory):  # it can begin with any of them
        facts = walk.in_any_order(node.child_nodes, facts)
    ways = _in_order(walk, node.child_nodes, facts, node._goes_on)
    if not node._yields or len(node.children) == 1:
        return ways
    return either(ways, *({RUNNING: way} for way in ways.values()))


def _reactive(walk: "Walk", node: Any, facts: Facts) -> Ways:
    return _settled(lambda now: _in_order(walk, node.child_nodes, now, node._goes_on), facts)


def _parallel(walk: "Walk", node: Parallel, facts: Facts) -> Ways:
    facts = walk.in_any_order(node.child_nodes, facts)
    ways = [walk.visit(child, facts) for child in node.child_nodes]
    wanted, tolerated = walk.number(node, "success_count"), walk.number(node, "failure_count")
    possible = dict.fromkeys((*COMPLETE, RUNNING), Way(facts))
    if wanted is not None and tolerated is not None:
        count, succeeds = len(ways), {SUCCESS, SKIPPED} if wanted < 0 else {SUCCESS}
        needed = threshold(int(wanted), count)
        if sum(not succeeds.isdisjoint(one) for one in ways) < needed:
            del possible[SUCCESS]
        enough = min(threshold(int(tolerated), count), count - needed + 1)
        if sum(FAILURE in one for one in ways) < enough:
            del possible[FAILURE]
    if not all(SKIPPED in one for one in ways):
        del possible[SKIPPED]
    return possible


def _branching(walk: "Walk", node: Any, facts: Facts) -> Ways:
    condition, *branches = node.child_nodes

    def flow(facts: Facts) -> Ways:
        asked = walk.visit(condition, facts)
        ways: Ways = {RUNNING: asked[RUNNING]} if RUNNING in asked else {}
        for index, (status, verb) in enumerate(((SUCCESS, "succeeds"), (FAILURE, "fails"))):
            branch = branches[index] if index < len(branches) else None
            if status not in asked:
                if branch is not None:
                    reason = f"the condition '{condition.name}' never {verb}"
                    walk.bar(branch, f"{reason}; remove one of them")
            elif branch is None:
                ways = either(ways, {FAILURE: asked[status]})
            else:
                way = asked[status]
                ways = either(ways, later(walk.visit(branch, way.facts), way.least))
        return ways

    return _settled(flow, facts) if isinstance(node, WhileDoElse) else flow(facts)


def _switch(walk: "Walk", node: Switch, facts: Facts) -> Ways:
    children = node.child_nodes
    return _settled(lambda now: either(*(walk.visit(child, now) for child in children)), facts)


def _try_catch(walk: "Walk", node: TryCatch, facts: Facts) -> Ways:
    *tried, last = node.child_nodes
    ways = dict(_in_order(walk, tried, facts, SUCCESS))
    failed = ways.pop(FAILURE, None)
    caught: Ways = {} if failed is None else {FAILURE: failed}
    if node.port_text("catch_on_halt") not in (None, "false", "0", "False") and RUNNING in ways:
        caught = either(caught, {FAILURE: Way(ways[RUNNING].facts)})
    if not caught:
        walk.bar(last, "no child before it can fail; remove it")
        return ways
    cleaned = later(walk.visit(last, caught[FAILURE].facts), caught[FAILURE].least)
    ended = _renamed(cleaned, {SUCCESS: FAILURE, SKIPPED: FAILURE})
    if failed is None:
        ended.pop(FAILURE, None)
    return either(ways, ended)


def _forcing(walk: "Walk", node: Any, facts: Facts) -> Ways:
    becomes = {SUCCESS: node._on_success, FAILURE: node._on_failure}
    return _renamed(walk.visit(node.child_node, facts), becomes)


def _until_failure(walk: "Walk", node: KeepRunningUntilFailure, facts: Facts) -> Ways:
    child, becomes = node.child_node, {SUCCESS: RUNNING, SKIPPED: RUNNING}
    return _settled(lambda now: _renamed(walk.visit(child, now), becomes), facts)


def _counting(walk: "Walk", node: Counting, facts: Facts) -> Ways:
    port, counted = node.port, node._counted
    most, visit = walk.number(node, port), partial(walk.visit, node.child_node)
    if most is not None and most < 1 and most != -1:
        if node.key_of(port) is None:  # else it may be meant: an option of the tree
            walk.bar(node.child_node, f"{port} is {most:g}; set it to the number of rounds")
        return {counted: Way(facts)}
    ways = dict(visit(facts) if most == 1 else _settled(visit, facts, counted))
    way = ways.pop(counted, None)
    if way is not None and most != 1:
        ways = either(ways, {RUNNING: Way(walk.incoming[id(node.child_node)])})
    if way is not None and most != -1:
        ways[counted] = Way(way.facts, way.least * (most or 1.0))
    return either(ways, {counted: Way(facts)}) if most is None else ways


def _delay(walk: "Walk", node: Delay, facts: Facts) -> Ways:
    ways = later(walk.visit(node.child_node, facts), walk.number(node, "delay_msec") or 0.0)
    return either(ways, {RUNNING: Way(facts)})


def _timeout(walk: "Walk", node: Timeout, facts: Facts) -> Ways:
    ways, limit = walk.visit(node.child_node, facts), walk.number(node, "msec")
    if limit == 0 or RUNNING not in ways:
        return ways
    late = {FAILURE: Way(ways[RUNNING].facts, limit or 0.0)}
    if limit is not None and least(ways) > limit:
        return {**late, RUNNING: ways[RUNNING]}
    return either(ways, late)


def _precondition(walk: "Walk", node: Precondition, facts: Facts) -> Ways:
    truth = constant_truth(script_of(node), node)
    if truth is False:
        walk.bar(node.child_node, "the condition above it never holds; remove it")
    otherwise = dict.fromkeys((*COMPLETE, RUNNING), Way(facts)) if not truth else {}
    return otherwise if truth is False else either(otherwise, walk.visit(node.child_node, facts))


REACTIVE: Final = (ReactiveSequence._tick, ReactiveFallback._tick)
BRANCHING: Final = (IfThenElse._tick, WhileDoElse._tick)
ORDERED: Final = (InOrder._tick, TryCatch._tick, *REACTIVE)
FLOWS: Final[dict[Any, Callable[["Walk", Any, Facts], Ways]]] = {
    InOrder._tick: _sequence,
    **dict.fromkeys(REACTIVE, _reactive),
    Parallel._tick: _parallel,
    **dict.fromkeys(BRANCHING, _branching),
    Switch._tick: _switch,
    TryCatch._tick: _try_catch,
    Inverter._tick: _forcing,
    KeepRunningUntilFailure._tick: _until_failure,
    Counting._tick: _counting,
    Delay._tick: _delay,
    Timeout._tick: _timeout,
    Precondition._tick: _precondition,
    SubTree._tick: lambda walk, node, facts: walk.visit(node.child_node, facts),
}
"""The flow of kinds of nodes, by the function of their tick."""
