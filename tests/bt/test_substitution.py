"""Other nodes in the place of some, for tests."""

import pytest

from bt_manip.bt import NodeStatus
from bt_manip.bt.nodes.test_node import TestNode, TestNodeConfig
from bt_manip.bt.substitution import matches, substitutions_from_json
from bt_manip.exceptions import TreeError

BODY = '<Sequence><Scripted name="move_a"/><Scripted name="move_b" outcomes="S"/></Sequence>'


def test_a_test_node_returns_what_a_function_of_python_says(bench):
    config = TestNodeConfig(complete_func=lambda: NodeStatus.FAILURE)

    assert bench.tree(BODY, substitutions={"move_b": config}).tick() is NodeStatus.FAILURE


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
