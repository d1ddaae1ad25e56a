"""What control nodes do with what their children return."""

import pytest

from bt_manip.bt import BehaviourRegistry, NodeStatus
from bt_manip.exceptions import NodeError


def node(tag, *children, **attributes):
    given = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f'<{tag} name="top"{given}>{"".join(children)}</{tag}>'


@pytest.mark.parametrize(
    ("tag", "first", "second", "roots"),
    [
        ("Sequence", "S", "S", "SSS"),
        ("Sequence", "F", "S", "FFF"),
        ("Sequence", "S", "F", "FFF"),
        ("Sequence", "RS", "S", "RSS"),
        ("Sequence", "K", "S", "SSS"),
        ("Sequence", "K", "K", "KKK"),
        ("AsyncSequence", "S", "S", "RSR"),
        ("SequenceWithMemory", "S", "FS", "RFS"),
        ("Fallback", "F", "F", "FFF"),
        ("Fallback", "F", "S", "SSS"),
        ("Fallback", "RS", "S", "RSS"),
        ("Fallback", "K", "F", "FFF"),
        ("Fallback", "K", "K", "KKK"),
        ("AsyncFallback", "F", "S", "RSR"),
        ("ReactiveSequence", "S", "RS", "RSS"),
        ("ReactiveSequence", "K", "K", "KKK"),
        ("ReactiveFallback", "F", "RF", "RFF"),
        ("ReactiveFallback", "S", "R", "SSS"),
        ("Parallel", "RS", "S", "RSS"),
        ("Parallel", "R", "F", "FFF"),
        ("Parallel", "K", "K", "SSS"),
        ("ParallelAll", "F", "RS", "RFF"),
        ("ParallelAll", "K", "K", "KKK"),
        ("ParallelAll", "K", "S", "SSS"),
        ("TryCatch", "F", "S", "FFF"),
        ("TryCatch", "S", "F", "SSS"),
        ("TryCatch", "K", "S", "KKK"),
    ],
)
def test_two_children_decide_the_result(bench, leaf, tag, first, second, roots):
    assert bench.ticks(node(tag, leaf("a", first), leaf("b", second))) == roots


def test_a_sequence_starts_anew_after_a_failure(bench, leaf):
    bench.ticks(node("Sequence", leaf("a", "S"), leaf("b", "FS")), 2)

    assert bench.events == ["a start S", "b start F", "a start S", "b start S"]


def test_a_sequence_with_memory_resumes_at_the_child_that_failed(bench, leaf):
    tree = bench.tree(node("SequenceWithMemory", leaf("a", "S"), leaf("b", "FS")))

    assert [tree.tick().name, tree.tick().name] == ["FAILURE", "SUCCESS"]
    assert bench.events == ["a start S", "b start F", "b start S"]


def test_a_yielding_node_is_invisible_to_a_tick_with_wake_ups(bench, leaf):
    tree = bench.tree(node("AsyncSequence", leaf("a", "S"), leaf("b", "S"), leaf("c", "S")))

    assert tree.tick() is NodeStatus.SUCCESS
    assert len(bench.events) == 3


def test_a_reactive_sequence_halts_the_others_when_one_runs(bench, leaf):
    bench.ticks(node("ReactiveSequence", leaf("a", "SR", mode="hold"), leaf("b", "R")), 2)

    assert bench.events == ["a start S", "b start R", "a start R", "b halt"]


@pytest.mark.parametrize(
    ("success", "failure", "children", "roots"),
    [
        ("1", "1", ["R", "S"], "SS"),
        ("-1", "1", ["S", "RS"], "RS"),
        ("2", "2", ["F", "S", "S"], "SS"),
        ("2", "-1", ["F", "F", "S"], "FF"),
        ("0", "1", ["R"], "SS"),
        ("1", "0", ["R"], "FF"),
    ],
)
def test_a_parallel_counts_to_its_thresholds(bench, leaf, success, failure, children, roots):
    body = node(
        "Parallel",
        *(leaf(f"c{i}", outcomes) for i, outcomes in enumerate(children)),
        success_count=success,
        failure_count=failure,
    )

    assert bench.ticks(body, 2) == roots


def test_a_parallel_does_not_tick_children_behind_a_verdict(bench, leaf):
    bench.ticks(node("Parallel", leaf("a", "S"), leaf("b", "S"), success_count="1"), 1)

    assert bench.events == ["a start S"]


def test_a_parallel_that_cannot_succeed_raises_at_its_tick(bench, leaf):
    tree = bench.tree(node("Parallel", leaf("a", "S"), success_count="2"))

    with pytest.raises(NodeError, match="top .* 1 children can never succeed: 2 must"):
        tree.tick()


def test_if_then_else_asks_its_condition_once(bench, leaf):
    bench.ticks(node("IfThenElse", leaf("if", "SF"), leaf("then", "RRS"), leaf("else", "S")), 3)

    assert bench.events == ["if start S", "then start R", "then running R", "then running S"]


def test_while_do_else_asks_its_condition_at_every_tick(bench, leaf):
    condition = '<ScriptedCondition name="while" outcomes="S,F"/>'
    bench.ticks(node("WhileDoElse", condition, leaf("do", "R"), leaf("else", "S")), 2)

    assert bench.events == [
        "while tick S",
        "do start R",
        "while tick F",
        "do halt",
        "else start S",
    ]


@pytest.mark.parametrize("tag", ["IfThenElse", "WhileDoElse"])
def test_a_skipped_condition_is_an_error(bench, leaf, tag):
    tree = bench.tree(node(tag, leaf("if", "K"), leaf("then", "S")))

    with pytest.raises(NodeError, match="the condition was skipped"):
        tree.tick()


def test_try_catch_cleans_up_and_fails(bench, leaf):
    body = node("TryCatch", leaf("a", "S"), leaf("b", "F"), leaf("clean", "RS"))

    assert bench.ticks(body, 2) == "RF"
    assert bench.events == ["a start S", "b start F", "clean start R", "clean running S"]


@pytest.mark.parametrize(("asked", "cleaned"), [("true", True), ("false", False)])
def test_try_catch_cleans_up_when_it_is_halted_if_asked_to(bench, leaf, asked, cleaned):
    tree = bench.tree(node("TryCatch", leaf("a", "R"), leaf("clean", "S"), catch_on_halt=asked))
    tree.tick()
    tree.halt()

    assert ("clean start S" in bench.events) is cleaned
    assert bench.events[1] == "a halt"


@pytest.mark.parametrize(
    ("variable", "cases", "chosen"),
    [
        ("a", ("a", "b"), "c0"),
        ("b", ("a", "b"), "c1"),
        ("z", ("a", "b"), "c2"),
        ("2", ("2.0", "GREEN"), "c0"),
        ("GREEN", ("1", "2"), "c1"),
        ("007", ("7", "8"), "c0"),
        ("0.5", (".5", "1"), "c0"),
        ("{missing}", ("a", "b"), "c2"),
    ],
)
def test_a_switch_chooses_by_text_number_or_enumeration(bench, leaf, variable, cases, chosen):
    body = node(
        "Switch2",
        *(leaf(f"c{i}", "S") for i in range(3)),
        variable=variable,
        case_1=cases[0],
        case_2=cases[1],
    )
    bench.ticks(body, 1)

    assert bench.events == [f"{chosen} start S"]


def test_a_switch_halts_its_child_when_the_variable_changes(bench, leaf):
    body = node(
        "Switch2", leaf("a", "R"), leaf("b", "R"), leaf("c", "R"),
        variable="{v}", case_1="1", case_2="2",
    )  # fmt: skip
    tree = bench.tree(body)
    tree.blackboard["v"] = "1"
    tree.tick()
    tree.blackboard["v"] = "2"
    tree.tick()

    assert bench.events == ["a start R", "a halt", "b start R"]


CONTROLS = [
    name for name in BehaviourRegistry().names() if BehaviourRegistry().get(name).kind == "Control"
]


@pytest.mark.parametrize("tag", CONTROLS)
def test_every_control_node_halts_what_runs_below_it(bench, leaf, tag):
    count = BehaviourRegistry().get(tag).most_children or 3
    tree = bench.tree(node(tag, *(leaf(f"c{i}", "R") for i in range(count))))
    tree.tick()
    bench.log.clear()
    tree.halt()

    assert bench.events and all(event.endswith("halt") for event in bench.events)
    assert set(tree.statuses()) == {NodeStatus.IDLE}


@pytest.mark.parametrize("tag", CONTROLS)
def test_every_control_node_gives_its_state_and_takes_it_back(bench, leaf, tag):
    count = BehaviourRegistry().get(tag).most_children or 3
    body = node(tag, *(leaf(f"c{i}", "SRFS", mode="cycle") for i in range(count)))
    tree = bench.tree(body)
    tree.tick_exactly_once()
    state = tree.nodes[0].get_state()
    other = bench.tree(body)
    other.nodes[0].set_state(state)

    assert other.nodes[0].get_state() == state
