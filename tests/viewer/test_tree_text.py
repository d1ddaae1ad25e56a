"""A tree as text shows who stands under whom and what each has come to."""

from bt_manip.bt import AlwaysFailure, AlwaysSuccess, Fallback, Sequence
from bt_manip.viewer.terminal_view import tree_lines


def test_children_stand_under_their_parents_with_plain_marks_in_a_plain_terminal():
    left = AlwaysSuccess("left")
    left.feedback_message = "done"
    tree = Sequence("all", [left, Fallback("some", [AlwaysFailure("right")])])
    statuses = {"all": "RUNNING", "left": "SUCCESS", "some": "RUNNING", "right": "RUNNING"}

    def shown(status_of, **options) -> list[str]:
        return [line.plain for line in tree_lines(tree, status_of, **options)]

    assert shown(lambda node: statuses[node.name]) == [
        "▶ all Sequence",
        "  ✓ left AlwaysSuccess  done",
        "  ▶ some Fallback",
        "    ▶ right AlwaysFailure",
    ]
    plain = shown(lambda node: statuses[node.name], ascii_only=True)
    assert plain[1] == "  + left AlwaysSuccess  done" and "".join(plain).isascii()
    idle = shown(lambda node: "IDLE")
    assert idle[1] == "  · left AlwaysSuccess"  # it says nothing of last time


def test_a_tree_deeper_than_pythons_stack_is_shown():
    node = AlwaysSuccess("leaf")
    for i in range(3000):
        node = Sequence(f"level {i}", [node])
    assert len(list(tree_lines(node, lambda node: "IDLE"))) == 3001
