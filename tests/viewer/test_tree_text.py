"""A tree as text shows who stands under whom and what each has come to."""

from bt_manip.bt import AlwaysFailure, AlwaysSuccess, Fallback, Sequence
from bt_manip.viewer.terminal_view import tree_lines


def test_children_stand_under_their_parents_with_plain_marks_in_a_plain_terminal():
    left, right = AlwaysSuccess("left"), AlwaysFailure("right")
    left.feedback_message = "done"
    tree = Sequence("all", [left, Fallback("some", [right])])
    statuses = dict.fromkeys([tree, *tree.children, right], "RUNNING") | {left: "SUCCESS"}
    assert [line.plain for line in tree_lines(tree, statuses)] == [
        "▶ all Sequence",
        "  ✓ left AlwaysSuccess  done",
        "  ▶ some Fallback",
        "    ▶ right AlwaysFailure",
    ]
    plain = [line.plain for line in tree_lines(tree, statuses, ascii_only=True)]
    assert plain[1] == "  + left AlwaysSuccess  done" and "".join(plain).isascii()
    _, idle, *_ = tree_lines(tree, {})
    assert idle.plain == "  · left AlwaysSuccess"  # it says nothing of last time


def test_a_tree_deeper_than_pythons_stack_is_shown():
    node = AlwaysSuccess("leaf")
    for i in range(3000):
        node = Sequence(f"level {i}", [node])
    assert len(list(tree_lines(node, {}))) == 3001
