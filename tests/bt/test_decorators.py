"""Decorators; the traces of the engine hold more of what they make of their child's status."""

from collections import deque

import pytest

from bt_manip.bt import BehaviourRegistry, NodeStatus
from bt_manip.exceptions import NodeError


def node(tag, child, **attributes):
    given = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f'<{tag} name="top"{given}>{child}</{tag}>'


@pytest.mark.parametrize(
    ("tag", "outcomes", "roots"),
    [
        ("Inverter", "SFRK", "FSRK"),
        ("ForceSuccess", "SFRK", "SSRK"),
        ("ForceFailure", "SFRK", "FFRK"),
        ("KeepRunningUntilFailure", "SKRF", "RRRF"),
        ("RunOnce", "KRSS", "KRSK"),
    ],
)
def test_a_decorator_maps_the_status_of_its_child(bench, leaf, tag, outcomes, roots):
    assert bench.ticks(node(tag, leaf("a", outcomes)), len(outcomes)) == roots


@pytest.mark.parametrize(
    ("cycles", "outcomes", "roots"),
    [("2", "RS", "RSRS"), ("3", "SF", "RFF"), ("0", "S", "SSS"), ("2", "SKS", "RKS")],
)
def test_repeat_counts_successes(bench, leaf, cycles, outcomes, roots):
    body = node("Repeat", leaf("a", outcomes), num_cycles=cycles)

    assert bench.ticks(body, len(roots)) == roots


@pytest.mark.parametrize(
    ("attempts", "outcomes", "roots"),
    [("2", "FS", "RS"), ("2", "FF", "RF"), ("0", "S", "FF"), ("-1", "F", "RRR")],
)
def test_retry_counts_failures(bench, leaf, attempts, outcomes, roots):
    body = node("RetryUntilSuccessful", leaf("a", outcomes), num_attempts=attempts)

    assert bench.ticks(body, len(roots)) == roots


def test_repeat_needs_its_number_of_cycles_at_the_tick(bench, leaf):
    tree = bench.tree(node("Repeat", leaf("a", "S")))

    with pytest.raises(NodeError, match="port 'num_cycles'"):
        tree.tick()


def test_a_precondition_is_asked_until_it_was_true_once(bench, leaf):
    tree = bench.tree(node("Precondition", leaf("a", "RRS"), **{"if": "go", "else": "SKIPPED"}))
    for go, *statuses in ((0, "SKIPPED"), (1, "RUNNING"), (0, "RUNNING", "SUCCESS", "SKIPPED")):
        tree.blackboard["go"] = go
        assert [tree.tick().name for _ in statuses] == statuses


def test_run_once_repeats_its_status_instead_of_skipping_if_asked_to(bench, leaf):
    tree = bench.tree(node("RunOnce", leaf("a", "F"), then_skip="false"))

    assert [tree.tick().name for _ in range(3)] == ["FAILURE"] * 3
    assert len(bench.events) == 1
    assert tree.failure_reason() == "top: a failed when it ran"


@pytest.mark.parametrize(
    ("tag", "queue", "items"),
    [
        ("LoopBool", "1;false", [True, False]),
        ("LoopDouble", "1.5;2", [1.5, 2.0]),
        ("LoopString", "", []),
    ],
)
def test_a_loop_hands_out_the_items_one_per_tick(bench, tag, queue, items):
    tree = bench.tree(
        node(tag, '<AlwaysSuccess name="a"/>', queue=queue, value="{item}", if_empty="SUCCESS")
    )
    seen = []
    while tree.tick() is NodeStatus.RUNNING:
        seen.append(tree.blackboard["item"])

    assert seen == items


def test_a_loop_copies_a_list_but_consumes_a_deque(bench):
    tree = bench.tree(node("LoopInt", "<AlwaysSuccess/>", queue="{items}", value="{item}"))
    tree.blackboard["items"] = [1, 2]
    assert [tree.tick().name for _ in range(3)] == ["RUNNING", "RUNNING", "SUCCESS"]
    assert tree.blackboard["items"] == [1, 2]
    items = deque([7, 8])
    tree.blackboard.entry("items").put(items, tree.blackboard.entry("items").type)
    tree.tick()
    assert list(items) == [8]


def test_a_loop_takes_what_is_no_list_for_an_error(bench):
    tree = bench.tree(node("LoopInt", "<AlwaysSuccess/>", queue="{items}", value="{item}"))
    tree.blackboard["items"] = 5

    with pytest.raises(NodeError, match="expected a list of int"):
        tree.tick()


@pytest.mark.parametrize(
    ("tag", "otherwise"), [("SkipUnlessUpdated", "K"), ("WaitValueUpdate", "R")]
)
def test_an_entry_that_was_written_lets_the_child_run(bench, leaf, tag, otherwise):
    writer = "<Sequence><Script code='x := 1'/>{}</Sequence>"
    watched = node(tag, leaf("a", "S"), entry="{x}")

    assert bench.ticks(watched, 2) == otherwise * 2
    assert bench.ticks(writer.format(watched), 2) == "SS"


class TestTime:
    """Delay, Timeout and Sleep count the clock that is handed in."""

    def test_a_clock_that_adds_up_time_steps_is_not_a_tick_late(self, bench, leaf):
        tree = bench.tree(node("Delay", leaf("a", "S"), delay_msec="100"))
        tree.tick()
        for _ in range(10):
            bench.clock.time += 0.01  # 0.09999999999999999 in the end
        assert tree.tick() is NodeStatus.SUCCESS

    def test_a_timeout_halts_its_child_before_the_next_tick(self, bench, leaf):
        body = (
            "<Parallel success_count='1'>"
            + leaf("first", "R")
            + node("Timeout", leaf("a", "R"), msec="50")
            + "</Parallel>"
        )
        tree = bench.tree(body)
        tree.tick()
        bench.clock.time = 0.05
        assert tree.tick() is NodeStatus.FAILURE
        assert bench.events == [
            "first start R",
            "a start R",
            "a halt",
            "first running R",
            "first halt",
        ]
        assert tree.failure_reason() == "top: a was still running after 50 ms"

    @pytest.mark.parametrize(
        "body", ['<Sleep msec="50"/>', '<Timeout msec="50"><Scripted outcomes="R"/></Timeout>']
    )
    def test_after_a_halt_it_counts_anew(self, bench, body):
        tree = bench.tree(body)
        tree.tick()
        tree.halt()
        bench.clock.time = 0.04
        tree.tick()
        bench.clock.time = 0.06
        assert tree.tick() is NodeStatus.RUNNING
        bench.clock.time = 0.09
        assert tree.tick() is not NodeStatus.RUNNING

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
        tree = bench.tree(body)
        tree.tick()
        bench.clock.time = 0.06
        state = tree.get_state()
        other = bench.tree(body)
        bench.clock.time = 5.0
        other.set_state(state)
        bench.clock.time = 5.03
        assert other.tick() is NodeStatus.RUNNING
        bench.clock.time = 5.05
        assert other.tick() is NodeStatus.SUCCESS


DECORATORS = [
    name
    for name in BehaviourRegistry().names()
    if BehaviourRegistry().get(name).kind == "Decorator"
]
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


@pytest.mark.parametrize("tag", DECORATORS)
def test_every_decorator_halts_its_running_child_and_gives_its_state(bench, leaf, tag):
    def tree_of(outcomes):
        body = node(tag, leaf("a", outcomes), **NEEDED.get(tag, {}))
        return bench.tree(f'<Sequence><Script code="x := 1"/>{body}</Sequence>')

    tree, other = tree_of("S"), tree_of("S")
    tree.tick_exactly_once()
    other.set_state(tree.get_state())
    assert other.get_state() == tree.get_state()

    tree = tree_of("R")
    tree.tick()
    tree.tick()
    tree.halt()
    assert "a start R" in bench.events and bench.events[-1] == "a halt"
    assert set(tree.statuses()) == {NodeStatus.IDLE}
