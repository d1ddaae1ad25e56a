"""Nodes of the language beside the engine's traces, which hold what they make of their children."""

from collections import deque

import pytest

from bt_manip.bt import BehaviourRegistry, NodeStatus
from bt_manip.exceptions import NodeError

SUCCEEDS = "<AlwaysSuccess/>"
SKIPPED = '<Scripted outcomes="K"/>'


def node(tag, *children, **attributes):
    given = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f'<{tag} name="top"{given}>{"".join(children)}</{tag}>'


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (node("Parallel", SUCCEEDS, success_count="2"), "1 children can never succeed: 2 must"),
        (node("IfThenElse", SKIPPED, SUCCEEDS), "the condition was skipped"),
        (node("WhileDoElse", SKIPPED, SUCCEEDS), "the condition was skipped"),
        (node("Repeat", SUCCEEDS), "port 'num_cycles' of top: nothing was given; expected int"),
        (node("LoopInt", SUCCEEDS, queue="{five}"), "expected a list of int or a text, found 5"),
    ],
)
def test_a_node_that_cannot_be_ticked_says_why(bench, body, message):
    tree = bench.tree(body)
    tree.blackboard["five"] = 5

    with pytest.raises(NodeError, match=f"top .*{message}"):
        tree.tick()


def test_a_yielding_node_is_invisible_to_a_tick_with_wake_ups(bench, leaf):
    tree = bench.tree(node("AsyncSequence", leaf("a", "S"), leaf("b", "S"), leaf("c", "S")))

    assert tree.tick() is NodeStatus.SUCCESS
    assert len(bench.events) == 3


def test_run_once_repeats_its_status_instead_of_skipping_if_asked_to(bench, leaf):
    tree = bench.tree(node("RunOnce", leaf("a", "F"), then_skip="false"))

    assert [tree.tick().name for _ in range(3)] == ["FAILURE"] * 3
    assert len(bench.events) == 1
    assert tree.failure_reason() == "top: a failed when it ran"


def test_a_loop_copies_a_list_but_consumes_a_deque(bench):
    tree = bench.tree(node("LoopInt", SUCCEEDS, queue="{items}", value="{item}"))
    tree.blackboard["items"] = [1, 2]
    assert [tree.tick().name for _ in range(3)] == ["RUNNING", "RUNNING", "SUCCESS"]
    assert tree.blackboard["items"] == [1, 2]
    items = deque([7, 8])
    tree.blackboard.entry("items").put(items, tree.blackboard.entry("items").type)
    tree.tick()
    assert list(items) == [8]


class TestSetBlackboard:
    """A text takes the type of its entry, and what another entry holds keeps its own."""

    TYPED = '<Sleep msec="{k}" _skipIf="true"/>'  # makes k an unsigned int
    REAL = '<Script code="h := 1.5"/>'

    def ticked(self, bench, before, value):
        setting = f'<SetBlackboard value="{value}" output_key="k"/>'
        tree = bench.tree(f"<Sequence>{before}{setting}</Sequence>")
        tree.tick()
        return tree

    @pytest.mark.parametrize(
        ("before", "value", "written"), [(TYPED, "7", 7), (REAL, "{h}", 1.5), ("", "{h}", None)]
    )
    def test_it_writes_or_fails_where_the_other_entry_was_never_written(
        self, bench, before, value, written
    ):
        tree = self.ticked(bench, before, value)
        assert tree.blackboard.get("k") == written
        assert ("entry 'h' was never written" in tree.failure_reason()) is (written is None)

    @pytest.mark.parametrize(
        ("before", "value", "message"),
        [
            ("", "abc", "entry 'k': 'abc' is not an integer"),
            (REAL, "{h}", "entry 'k' holds unsigned int; it does not take double"),
        ],
    )
    def test_a_value_that_is_none_of_the_entrys_type_is_an_error(
        self, bench, before, value, message
    ):
        with pytest.raises(NodeError, match=message):
            self.ticked(bench, before + self.TYPED, value)


class TestTime:
    """Delay, Timeout and Sleep count the clock that is handed in."""

    def test_a_clock_that_adds_up_time_steps_is_not_a_tick_late(self, bench, leaf):
        tree = bench.tree(node("Delay", leaf("a", "S"), delay_msec="100"))
        tree.tick()
        for _ in range(10):
            bench.clock.time += 0.01  # 0.09999999999999999 in the end
        assert tree.tick() is NodeStatus.SUCCESS

    def test_a_timeout_says_which_child_was_still_running(self, bench, leaf):
        tree = bench.tree(node("Timeout", leaf("a", "R"), msec="50"))
        tree.tick()
        bench.clock.time = 0.05
        assert tree.tick() is NodeStatus.FAILURE
        assert tree.failure_reason() == "top: a was still running after 50 ms"

    def test_no_timers_pile_up(self, bench, leaf):
        tree = bench.tree(node("Timeout", leaf("a", "S"), msec="1000000"))
        for _ in range(100):
            tree.tick()
        assert tree._runtime.timers == {}

    @pytest.mark.parametrize(
        "body",
        [
            '<Delay delay_msec="100"><AlwaysSuccess/></Delay>',
            '<Sleep msec="100"/>',
            '<ForceSuccess><Timeout msec="100"><Scripted outcomes="R"/></Timeout></ForceSuccess>',
        ],
    )
    def test_a_timer_goes_on_after_a_snapshot(self, bench, body):
        tree, other = bench.tree(body), bench.tree(body)
        tree.tick()
        bench.clock.time = 0.06
        state = tree.get_state()
        bench.clock.time = 5.0
        other.set_state(state)
        bench.clock.time = 5.03
        assert other.tick() is NodeStatus.RUNNING
        bench.clock.time = 5.05
        assert other.tick() is NodeStatus.SUCCESS


REGISTRY = BehaviourRegistry()
PARENTS = [n for n in REGISTRY.names() if REGISTRY.get(n).kind in ("Control", "Decorator")]
NEEDED = {
    "Repeat": {"num_cycles": "3"},
    "RetryUntilSuccessful": {"num_attempts": "3"},
    "Delay": {"delay_msec": "0"},
    "Timeout": {"msec": "100"},
    "Precondition": {"if": "true"},
    "SkipUnlessUpdated": {"entry": "{x}"},
    "WaitValueUpdate": {"entry": "{x}"},
    **{f"Loop{t}": {"queue": "1;1", "value": "{v}"} for t in ("Int", "Bool", "Double", "String")},
}


@pytest.mark.parametrize("tag", PARENTS)
def test_every_parent_halts_what_runs_below_it_and_gives_its_state(bench, leaf, tag):
    cls = REGISTRY.get(tag)
    count = 1 if cls.kind == "Decorator" else cls.most_children or 3

    def tree_of(outcomes):
        children = (leaf(f"c{i}", outcomes) for i in range(count))
        body = node(tag, *children, **NEEDED.get(tag, {}))
        return bench.tree(f'<Sequence><Script code="x := 1"/>{body}</Sequence>')

    tree, other = tree_of("SRFS"), tree_of("SRFS")
    tree.tick_exactly_once()
    other.set_state(tree.get_state())
    assert other.get_state() == tree.get_state()

    tree = tree_of("R")
    tree.tick()
    tree.tick()
    bench.log.clear()
    tree.halt()
    assert bench.events and all(event.endswith("halt") for event in bench.events)
    assert set(tree.statuses()) == {NodeStatus.IDLE}
