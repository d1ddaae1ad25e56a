"""The decorators of MoveIt Pro."""

import pytest

from bt_manip.bt import BehaviourRegistry, parse_tree
from bt_manip_moveit_pro.dialect import MOVEIT_PRO

TREE = '<root><BehaviorTree ID="Main">{}</BehaviorTree></root>'


def make(text):
    registry = BehaviourRegistry()
    registry.register_dialect(MOVEIT_PRO)
    return parse_tree(TREE.format(text), registry, dialect="auto")


def statuses(tree, ticks):
    return [tree.tick().name for _ in range(ticks)]


def test_repeat_unless_failure_each_tick_ticks_its_child_once_a_tick():
    tree = make(
        '<RepeatUnlessFailureEachTick num_cycles="3"><Script code="n := 1"/>'
        "</RepeatUnlessFailureEachTick>"
    )
    assert statuses(tree, 3) == ["RUNNING", "RUNNING", "SUCCESS"]


def test_repeat_unless_failure_each_tick_never_ends_by_default():
    tree = make("<RepeatUnlessFailureEachTick><AlwaysSuccess/></RepeatUnlessFailureEachTick>")
    assert set(statuses(tree, 50)) == {"RUNNING"}


@pytest.mark.parametrize("name", ["EachTick", "WithinTick"])
def test_repeat_unless_failure_fails_with_its_child(name):
    name = f"RepeatUnlessFailure{name}"
    tree = make(f'<{name} num_cycles="3"><AlwaysFailure/></{name}>')
    assert statuses(tree, 1) == ["FAILURE"]


def test_for_each_until_success_ends_with_the_first_item_that_does():
    tree = make(
        '<ForEachUntilSuccess vector_in="4;5;6" out="{x}" index="{i}">'
        '<ScriptCondition code="i == 1"/></ForEachUntilSuccess>'
    )
    assert statuses(tree, 2) == ["RUNNING", "SUCCESS"]
    assert tree.blackboard["i"] == 1


def test_for_each_until_success_fails_when_no_item_does():
    tree = make('<ForEachUntilSuccess vector_in="4;5"><AlwaysFailure/></ForEachUntilSuccess>')
    assert statuses(tree, 2) == ["RUNNING", "FAILURE"]
    tree = make('<ForEachUntilSuccess vector_in="{none}"><AlwaysSuccess/></ForEachUntilSuccess>')
    tree.blackboard["none"] = []
    assert statuses(tree, 1) == ["FAILURE"]
