"""A tree as text shows who stands under whom and what each has come to."""

from bt_manip.bt import AlwaysFailure, AlwaysSuccess, Fallback, Sequence
from bt_manip.viewer.terminal_view import tree_lines


def tree() -> Sequence:
    left = AlwaysSuccess("left")
    left.feedback_message = "done"
    return Sequence("all", [left, Fallback("some", [AlwaysFailure("right")])])


STATUSES = {"all": "RUNNING", "left": "SUCCESS", "some": "RUNNING", "right": "RUNNING"}


def status_of(node) -> str:
    return STATUSES[node.name]


def test_children_stand_under_their_parents():
    lines = [line.plain for line in tree_lines(tree(), status_of)]
    assert lines == [
        "▶ all Sequence",
        "  ✓ left AlwaysSuccess  done",
        "  ▶ some Fallback",
        "    ▶ right AlwaysFailure",
    ]


def test_a_plain_terminal_gets_plain_marks():
    text = "\n".join(line.plain for line in tree_lines(tree(), status_of, ascii_only=True))
    assert text.isascii()
    assert text.splitlines()[1] == "  + left AlwaysSuccess  done"
    idle = [line.plain for line in tree_lines(tree(), lambda node: "IDLE")]
    assert idle[1] == "  · left AlwaysSuccess"  # it says nothing of last time


def test_a_tree_deeper_than_pythons_stack_is_shown():
    node = AlwaysSuccess("leaf")
    for i in range(3000):
        node = Sequence(f"level {i}", [node])
    assert len(list(tree_lines(node, lambda node: "IDLE"))) == 3001
