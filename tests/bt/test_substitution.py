"""Other nodes in the place of some, for tests."""

import pytest

from bt_manip.bt import NodeStatus
from bt_manip.bt.nodes.test_node import TestNode, TestNodeConfig
from bt_manip.bt.substitution import matches, substitutions_from_json
from bt_manip.exceptions import TreeError

BODY = '<Sequence><Scripted name="move_a"/><Scripted name="move_b" outcomes="S"/></Sequence>'


@pytest.mark.parametrize(
    ("pattern", "replaced"),
    [("move_a", 1), ("Scripted", 2), ("move_?", 2), ("x*", 0)],
)
def test_a_rule_applies_by_name_by_class_or_by_path(bench, pattern, replaced):
    tree = bench.tree(BODY, substitutions={pattern: "AlwaysSuccess"})
    tree.tick()

    assert len(bench.events) == 2 - replaced


@pytest.mark.parametrize(
    ("config", "roots"),
    [
        (TestNodeConfig(return_status=NodeStatus.FAILURE), "F"),
        (TestNodeConfig(return_status=NodeStatus.SKIPPED), "S"),
        (TestNodeConfig(return_status_script="n > 0 ? SUCCESS : FAILURE"), "F"),
        (TestNodeConfig(return_status_script="'SUCCESS'"), "S"),
        (TestNodeConfig(complete_func=lambda: NodeStatus.FAILURE), "F"),
    ],
)
def test_a_test_node_returns_what_it_is_asked_for(bench, config, roots):
    tree = bench.tree(BODY, substitutions={"move_b": config})
    tree.blackboard["n"] = 0

    assert tree.tick().name[0] == roots


@pytest.mark.parametrize("pattern", ["sub", "sub/leaf", "Scripted"])
def test_a_sub_tree_and_a_node_in_it_are_found_by_their_paths(bench, pattern):
    other = '<BehaviorTree ID="Sub"><Scripted name="leaf"/></BehaviorTree>'
    rules = {pattern: TestNodeConfig(return_status=NodeStatus.FAILURE, async_delay=200)}
    tree = bench.tree('<SubTree ID="Sub" name="sub"/>', other, substitutions=rules)

    assert tree.tick() is NodeStatus.RUNNING
    bench.clock.time = 0.2
    assert tree.tick() is NodeStatus.FAILURE and bench.events == []


def test_an_unknown_replacement_is_an_error_of_the_document(bench):
    with pytest.raises(TreeError, match="no behaviour is named 'Nope'"):
        bench.tree(BODY, substitutions={"move_a": "Nope"})


def test_a_test_node_cannot_return_idle():
    with pytest.raises(TreeError, match="cannot return IDLE"):
        TestNode(config=TestNodeConfig(return_status=NodeStatus.IDLE))


def test_rules_are_read_from_the_engines_json():
    rules = substitutions_from_json(
        '{"TestNodeConfigs": {"Fail": {"return_status": "FAILURE", "async_delay": 5}},'
        ' "SubstitutionRules": {"a/*": "Fail", "b": "AlwaysSuccess"}}'
    )

    assert rules == {
        "a/*": TestNodeConfig(return_status=NodeStatus.FAILURE, async_delay=5),
        "b": "AlwaysSuccess",
    }


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        '{"TestNodeConfigs": {"A": {}}, "SubstitutionRules": {}}',
        '{"TestNodeConfigs": {"A": {"return_status": "NO"}}, "SubstitutionRules": {}}',
    ],
)
def test_bad_rules_are_refused(text):
    with pytest.raises(TreeError):
        substitutions_from_json(text)


def test_a_pattern_is_no_regular_expression():
    assert matches("a.b", "a.b") and not matches("axb", "a.b")
    assert matches("", "*") and matches("anything/at all", "**") and not matches("", "?")
