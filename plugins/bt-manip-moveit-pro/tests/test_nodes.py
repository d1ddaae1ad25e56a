"""The decorators of MoveIt Pro."""

import pytest

from bt_manip.bt import BehaviourRegistry, parse_tree
from bt_manip_moveit_pro.dialect import MOVEIT_PRO

TREE = '<root><BehaviorTree ID="Main">{}</BehaviorTree></root>'


def make(text):
    registry = BehaviourRegistry()
    registry.register_dialect(MOVEIT_PRO)
    return parse_tree(TREE.format(text), registry, dialect="auto")


@pytest.mark.parametrize(
    ("node", "child", "statuses"),
    [
        ('RepeatUnlessFailureEachTick num_cycles="3"', '<Script code="n := 1"/>', "RRS"),
        ("RepeatUnlessFailureEachTick", "<AlwaysSuccess/>", "R" * 50),  # never ends
        ('RepeatUnlessFailureEachTick num_cycles="3"', "<AlwaysFailure/>", "F"),
        ('RepeatUnlessFailureWithinTick num_cycles="3"', "<AlwaysFailure/>", "F"),
        ('ForEachUntilSuccess vector_in="4;5"', "<AlwaysFailure/>", "RF"),
        ('ForEachUntilSuccess vector_in=""', "<AlwaysSuccess/>", "F"),
    ],
)
def test_decorators_tick_their_child_once_a_tick_until_they_complete(node, child, statuses):
    tree = make(f"<{node}>{child}</{node.split()[0]}>")
    assert "".join(tree.tick().name[0] for _ in statuses) == statuses


def test_for_each_until_success_ends_with_the_first_item_that_does():
    tree = make(
        '<ForEachUntilSuccess vector_in="4;5;6" out="{x}" index="{i}">'
        '<ScriptCondition code="i == 1"/></ForEachUntilSuccess>'
    )
    assert [tree.tick().name for _ in range(2)] == ["RUNNING", "SUCCESS"]
    assert tree.blackboard["i"] == 1
