"""SetBlackboard does what its section of the page says."""

import pytest

from bt_manip.bt import BehaviourRegistry, NodeStatus, parse_tree
from bt_manip.exceptions import NodeError

TYPED = '<Sleep msec="{k}" _skipIf="true"/>'  # makes k an unsigned int


def tree_of(before, value):
    setting = f'<SetBlackboard value="{value}" output_key="k"/>'
    body = f'<BehaviorTree ID="Main"><Sequence>{before}{setting}</Sequence></BehaviorTree>'
    return parse_tree(f'<root BTCPP_format="4">{body}</root>', BehaviourRegistry())


@pytest.mark.parametrize(
    ("before", "value", "written"), [(TYPED, "7", 7), ('<Script code="h := 1.5"/>', "{h}", 1.5)]
)
def test_a_text_takes_the_type_of_the_entry_and_that_of_another_one_is_kept(before, value, written):
    tree = tree_of(before, value)
    assert tree.tick() is NodeStatus.SUCCESS
    assert tree.blackboard["k"] == written


def test_it_fails_when_the_other_entry_was_never_written():
    tree = tree_of("", "{h}")
    assert tree.tick() is NodeStatus.FAILURE
    assert "entry 'h' was never written" in tree.failure_reason()


@pytest.mark.parametrize(
    ("before", "value", "message"),
    [
        ("", "abc", "entry 'k': 'abc' is not an integer"),
        (
            '<Script code="h := 1.5"/>', "{h}",
            "entry 'k' holds unsigned int; it does not take double",
        ),
    ],
)  # fmt: skip
def test_a_value_that_is_none_of_the_entrys_type_is_an_error_of_the_tree(before, value, message):
    tree = tree_of(before + TYPED, value)
    with pytest.raises(NodeError, match=message):
        tree.tick()
