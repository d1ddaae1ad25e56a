"""How facts flow through nodes that have children.

Each function mirrors the rules of one node's tick. Nodes without one can do anything, as far as the
checks know.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import inf
from typing import Any, Final

from bt_manip.bt.analysis.facts import Facts, join
from bt_manip.bt.analysis.walk import (
    COMPLETE,
    Flow,
    Outcomes,
    Walk,
    Way,
    either,
    literal,
)
from bt_manip.bt.nodes.controls.branching import IfThenElse, WhileDoElse
from bt_manip.bt.nodes.controls.parallel import Parallel, threshold
from bt_manip.bt.nodes.controls.reactive import ReactiveFallback, ReactiveSequence
from bt_manip.bt.nodes.controls.sequence import InOrder, SequenceWithMemory
from bt_manip.bt.nodes.controls.switch import Switch
from bt_manip.bt.nodes.controls.try_catch import TryCatch
from bt_manip.bt.nodes.decorators.forcing import Inverter
from bt_manip.bt.nodes.decorators.repeat import Repeat
from bt_manip.bt.nodes.decorators.timing import Delay, Timeout
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.status import FAILURE, SKIPPED, SUCCESS, NodeStatus


def _made(ways: dict[NodeStatus, Way | None], running: Facts | None) -> Outcomes:
    return Outcomes(ways.get(SUCCESS), ways.get(FAILURE), ways.get(SKIPPED), running)


def _running(found: Facts | None, more: Facts | None) -> Facts | None:
    return found if more is None else join(found, more)


def _settled(facts: Facts, flow: Callable[[Facts], tuple[Outcomes, Facts | None]]) -> Outcomes:
    """Return the outcomes of a node that is entered again with what its own ticks leave.

    Args:
        facts: What holds at first.
        flow: Gives the outcomes with some facts, and what may hold when it is entered again.
    """
    while True:
        outcomes, left = flow(facts)
        again = join(facts, left)
        if again is facts:
            return outcomes
        facts = again


def _in_order(
    walk: Walk,
    children: list[Any],
    facts: Facts,
    goes_on: NodeStatus,
    *,
    entry: Facts | None = None,
    together: bool = False,
) -> Outcomes:
    """Return the outcomes of children that are ticked one after the other.

    Args:
        walk: The walk.
        children: The children.
        facts: What holds before the first one.
        goes_on: The status after which the next one is ticked; the other one ends the round.
        entry: What may hold before any of them, where a round can begin with it.
        together: Whether each child is ticked anew in every tick: times do not add up.
    """
    ends = FAILURE if goes_on is SUCCESS else SUCCESS
    ended: Way | None = None
    running: Facts | None = None
    way, all_skipped = Way(facts), True
    some = False
    for index, child in enumerate(children):
        outcomes = walk.visit(
            child, join(way.facts, entry) if entry is not None and index else way.facts
        )
        elapsed = 0.0 if together else way.least
        ended = either(ended, outcomes.of(ends), elapsed)
        running = _running(running, outcomes.running)
        some |= outcomes.of(goes_on) is not None
        all_skipped &= outcomes.skipped is not None
        next_way = either(either(None, outcomes.of(goes_on), elapsed), outcomes.skipped, elapsed)
        if next_way is None:
            verb = "never completes"
            if outcomes.of(ends) is not None:
                verb = "always succeeds" if ends is SUCCESS else "always fails"
            for following in children[index + 1 : index + 2]:
                walk.barred.setdefault(
                    id(following),
                    f"'{child.name}' before it {verb}; remove it, or change their order",
                )
            return _made({ends: ended}, running)
        way = Way(next_way.facts, max(way.least, next_way.least))
    return _made(
        {ends: ended, goes_on: way if some else None, SKIPPED: way if all_skipped else None},
        running,
    )


def _sequence(walk: Walk, node: InOrder, facts: Facts) -> Outcomes:
    entry = facts if isinstance(node, SequenceWithMemory) else None
    outcomes = _in_order(walk, node.child_nodes, facts, node._goes_on, entry=entry)
    if not node._yields or len(node.children) == 1:
        return outcomes
    return _made(
        {status: outcomes.of(status) for status in COMPLETE},
        join(outcomes.running, outcomes.facts),
    )


def _reactive(walk: Walk, node: Any, facts: Facts) -> Outcomes:
    def flow(facts: Facts) -> tuple[Outcomes, Facts | None]:
        outcomes = _in_order(walk, node.child_nodes, facts, node._goes_on, together=True)
        return outcomes, outcomes.running

    return _settled(facts, flow)


def _together(walk: Walk, children: list[Any], facts: Facts) -> tuple[list[Outcomes], Facts]:
    """Visit children that run side by side; return their outcomes and what may hold after all."""
    facts = walk.in_any_order(children, facts)
    return [walk.visit(child, facts) for child in children], facts


def _nth(ways: Iterable[Way | None], count: int) -> float:
    """Return the shortest time after which `count` of the ways have ended [ms]."""
    times = sorted(way.least for way in ways if way is not None)
    return 0.0 if count <= 0 else times[count - 1] if count <= len(times) else inf


def _parallel(walk: Walk, node: Parallel, facts: Facts) -> Outcomes:
    outcomes, facts = _together(walk, node.child_nodes, facts)
    wanted, tolerated = literal(node, "success_count"), literal(node, "failure_count")
    if wanted is None or tolerated is None:
        return Outcomes(Way(facts), Way(facts), Way(facts), facts)
    count = len(outcomes)
    needed = threshold(int(wanted), count)
    enough = min(threshold(int(tolerated), count), count - needed + 1)
    successes = [either(one.success, one.skipped if wanted < 0 else None) for one in outcomes]
    success, failure = (
        _nth(successes, needed),
        _nth([one.failure for one in outcomes], enough),
    )
    return Outcomes(
        Way(facts, success) if success < inf else None,
        Way(facts, failure) if failure < inf else None,
        Way(facts) if all(one.skipped is not None for one in outcomes) else None,
        facts,
    )


def _branching(walk: Walk, node: Any, facts: Facts) -> Outcomes:
    children = node.child_nodes
    if len(children) not in (2, 3):
        return Outcomes()
    reactive = isinstance(node, WhileDoElse)

    def flow(facts: Facts) -> tuple[Outcomes, Facts | None]:
        asked = walk.visit(children[0], facts)
        result = Outcomes(running=asked.running)
        for index, way, text in (
            (1, asked.success, "never succeeds"),
            (2, asked.failure, "never fails"),
        ):
            if way is None:
                if index < len(children):
                    walk.barred.setdefault(
                        id(children[index]),
                        f"the condition '{children[0].name}' {text}; remove one of them",
                    )
            elif index == len(children):
                result = _merged(result, Outcomes(failure=way))
            else:
                branch = walk.visit(children[index], way.facts)
                result = _merged(result, _later(branch, 0.0 if reactive else way.least))
        return result, result.running if reactive else None

    return _settled(facts, flow)


def _later(outcomes: Outcomes, after: float) -> Outcomes:
    """Return outcomes that begin some time later [ms]."""
    ways = {status: either(None, outcomes.of(status), after) for status in COMPLETE}
    return _made(ways, outcomes.running)


def _merged(first: Outcomes, second: Outcomes) -> Outcomes:
    return Outcomes(
        either(first.success, second.success),
        either(first.failure, second.failure),
        either(first.skipped, second.skipped),
        _running(first.running, second.running),
    )


def _switch(walk: Walk, node: Switch, facts: Facts) -> Outcomes:
    def flow(facts: Facts) -> tuple[Outcomes, Facts | None]:
        result = Outcomes()
        for child in node.child_nodes:
            result = _merged(result, walk.visit(child, facts))
        return result, result.running

    return _settled(facts, flow)


def _try_catch(walk: Walk, node: TryCatch, facts: Facts) -> Outcomes:
    children = node.child_nodes
    if len(children) < 2:
        return Outcomes()
    tried = _in_order(walk, children[:-1], facts, SUCCESS)
    caught = tried.failure
    if node.port_text("catch_on_halt") not in (None, "false", "0", "False"):
        caught = either(caught, None if tried.running is None else Way(tried.running))
    failure, running = None, tried.running
    if caught is None:
        walk.barred.setdefault(id(children[-1]), "no child before it can fail; remove it")
    else:
        cleaned = walk.visit(children[-1], caught.facts)
        for status in COMPLETE:
            failure = either(failure, cleaned.of(status), caught.least)
        running = _running(running, cleaned.running)
        if tried.failure is None:
            failure = None
    return Outcomes(tried.success, failure, tried.skipped, running)


def _forcing(walk: Walk, node: Any, facts: Facts) -> Outcomes:
    child = walk.visit(node.child_node, facts)
    ways: dict[NodeStatus, Way | None] = {SKIPPED: child.skipped}
    for way, status in ((child.success, node._on_success), (child.failure, node._on_failure)):
        ways[status] = either(ways.get(status), way)
    return _made(ways, child.running)


def _counting(walk: Walk, node: Any, facts: Facts) -> Outcomes:
    port, counted = (
        ("num_cycles", SUCCESS) if isinstance(node, Repeat) else ("num_attempts", FAILURE)
    )
    most = literal(node, port)
    child, before = node.child_node, facts
    if most == 0:
        walk.barred.setdefault(id(child), f"{port} is 0; set it to the number of rounds")
        return _made({counted: Way(facts)}, None)

    def flow(facts: Facts) -> tuple[Outcomes, Facts | None]:
        outcomes = walk.visit(child, facts)
        way = outcomes.of(counted)
        return outcomes, None if way is None or most == 1 else way.facts

    outcomes = _settled(facts, flow)
    facts = walk.incoming[id(child)]
    way = outcomes.of(counted)
    running = outcomes.running
    if most != 1 and way is not None:
        running = _running(running, facts)
    rounds = 1.0 if most is None else most
    last = None if way is None or most == -1 else Way(way.facts, way.least * rounds)
    ways = {status: outcomes.of(status) for status in COMPLETE}
    ways[counted] = last
    if most is None:
        ways[counted] = either(last, Way(before))
    return _made(ways, running)


def _delay(walk: Walk, node: Delay, facts: Facts) -> Outcomes:
    child = walk.visit(node.child_node, facts)
    waited = _later(child, literal(node, "delay_msec") or 0.0)
    return replace(waited, running=_running(facts, child.running))


def _timeout(walk: Walk, node: Timeout, facts: Facts) -> Outcomes:
    child = walk.visit(node.child_node, facts)
    limit = literal(node, "msec")
    if limit == 0 or child.running is None:
        return child
    late = Way(child.running, limit or 0.0)
    if limit is not None and child.least > limit:
        return Outcomes(failure=late, running=child.running)
    return Outcomes(child.success, either(child.failure, late), child.skipped, child.running)


def _pass(walk: Walk, node: Any, facts: Facts) -> Outcomes:
    return walk.visit(node.child_node, facts)


FLOWS: Final[dict[Any, Flow]] = {
    InOrder._tick: _sequence,
    ReactiveSequence._tick: _reactive,
    ReactiveFallback._tick: _reactive,
    Parallel._tick: _parallel,
    IfThenElse._tick: _branching,
    WhileDoElse._tick: _branching,
    Switch._tick: _switch,
    TryCatch._tick: _try_catch,
    Inverter._tick: _forcing,
    Repeat._tick: _counting,
    Delay._tick: _delay,
    Timeout._tick: _timeout,
    SubTree._tick: _pass,
}
"""The flow of kinds of nodes, by the function of their tick."""
