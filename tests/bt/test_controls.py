"""Control nodes, one case of each kind; the traces of the engine hold all others."""

import pytest

from bt_manip.bt import BehaviourRegistry, NodeStatus
from bt_manip.exceptions import NodeError


def node(tag, *children, **attributes):
    given = "".join(f' {key}="{value}"' for key, value in attributes.items())
    return f'<{tag} name="top"{given}>{"".join(children)}</{tag}>'


@pytest.mark.parametrize(
    ("tag", "first", "second", "roots"),
    [
        ("Sequence", "RS", "S", "RSS"),
        ("Sequence", "K", "K", "KKK"),
        ("AsyncSequence", "S", "S", "RSR"),
        ("SequenceWithMemory", "S", "FS", "RFS"),
        ("Fallback", "RS", "S", "RSS"),
        ("Fallback", "K", "K", "KKK"),
        ("AsyncFallback", "F", "S", "RSR"),
        ("ReactiveSequence", "S", "RS", "RSS"),
        ("ReactiveFallback", "F", "RF", "RFF"),
        ("Parallel", "RS", "S", "RSS"),
        ("Parallel", "K", "K", "SSS"),
        ("ParallelAll", "F", "RS", "RFF"),
        ("TryCatch", "F", "S", "FFF"),
        ("TryCatch", "S", "F", "SSS"),
    ],
)
def test_two_children_decide_the_result(bench, leaf, tag, first, second, roots):
    assert bench.ticks(node(tag, leaf("a", first), leaf("b", second))) == roots


def test_a_yielding_node_is_invisible_to_a_tick_with_wake_ups(bench, leaf):
    tree = bench.tree(node("AsyncSequence", leaf("a", "S"), leaf("b", "S"), leaf("c", "S")))

    assert tree.tick() is NodeStatus.SUCCESS
    assert len(bench.events) == 3


@pytest.mark.parametrize(
    ("success", "failure", "children", "roots"),
    [
        ("-1", "1", ["S", "RS"], "RS"),
        ("2", "-1", ["F", "F", "S"], "FF"),
        ("0", "1", ["R"], "SS"),
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


def test_a_parallel_that_cannot_succeed_raises_at_its_tick(bench, leaf):
    tree = bench.tree(node("Parallel", leaf("a", "S"), success_count="2"))

    with pytest.raises(NodeError, match="top .* 1 children can never succeed: 2 must"):
        tree.tick()


def test_while_do_else_halts_the_other_child_when_its_condition_changes(bench, leaf):
    condition = '<ScriptedCondition name="while" outcomes="F,S,F"/>'
    bench.ticks(node("WhileDoElse", condition, leaf("do", "R"), leaf("else", "R")), 3)

    assert [event for event in bench.events if not event.startswith("while")] == [
        "else start R", "else halt", "do start R", "do halt", "else start R",
    ]  # fmt: skip
    assert bench.ticks(node("WhileDoElse", leaf("while", "F"), leaf("do", "R"))) == "FFF"


@pytest.mark.parametrize("tag", ["IfThenElse", "WhileDoElse"])
def test_a_skipped_condition_is_an_error(bench, leaf, tag):
    tree = bench.tree(node(tag, leaf("if", "K"), leaf("then", "S")))

    with pytest.raises(NodeError, match="the condition was skipped"):
        tree.tick()


def test_try_catch_cleans_up_and_fails_and_begins_anew(bench, leaf):
    body = node("TryCatch", leaf("a", "S"), leaf("b", "FS"), leaf("clean", "RS"))

    assert bench.ticks(body, 3) == "RFS"
    assert bench.events == [
        "a start S", "b start F", "clean start R", "clean running S", "a start S", "b start S",
    ]  # fmt: skip


@pytest.mark.parametrize("asked", ["true", "false"])
def test_try_catch_cleans_up_when_it_is_halted_if_asked_to(bench, leaf, asked):
    body = node("TryCatch", leaf("a", "S"), leaf("b", "R"), leaf("c", "R"), catch_on_halt=asked)
    tree = bench.tree(body)
    for _ in range(2):
        tree.tick()
        tree.halt()
    cleaning = ["c start R", "c halt"] if asked == "true" else []

    assert bench.events == ["a start S", "b start R", "b halt", *cleaning] * 2


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
    children = (leaf("a", "R"), leaf("b", "RS"), leaf("c", "S"))
    tree = bench.tree(node("Switch2", *children, variable="{v}", case_1="1", case_2="2"))
    for value in "1223":
        tree.blackboard["v"] = value
        tree.tick()

    assert bench.events == ["a start R", "a halt", "b start R", "b running S", "c start S"]


CONTROLS = [
    name for name in BehaviourRegistry().names() if BehaviourRegistry().get(name).kind == "Control"
]


@pytest.mark.parametrize("tag", CONTROLS)
def test_every_control_node_halts_what_runs_below_it_and_gives_its_state(bench, leaf, tag):
    count = BehaviourRegistry().get(tag).most_children or 3

    def tree_of(outcomes):
        return bench.tree(node(tag, *(leaf(f"c{i}", outcomes) for i in range(count))))

    tree, other = tree_of("SRFS"), tree_of("SRFS")
    tree.tick_exactly_once()
    state = tree.nodes[0].get_state()
    other.nodes[0].set_state(state)
    assert other.nodes[0].get_state() == state

    tree = tree_of("R")
    tree.tick()
    bench.log.clear()
    tree.halt()
    assert bench.events and all(event.endswith("halt") for event in bench.events)
    assert set(tree.statuses()) == {NodeStatus.IDLE}
