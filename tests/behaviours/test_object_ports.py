"""Ports that name several objects, in leaves and in goals."""

import pytest

from bt_manip.behaviours import CellBehaviour, IsHolding, IsIn, IsOn, ObjectExists, ObjectInput
from bt_manip.bt import AlwaysSuccess, NodeStatus, Sequence, Status, Tree, tree_to_xml
from bt_manip.cell.objects import Box, Cube
from bt_manip.exceptions import NodeError
from bt_manip.runner import GoalJudge
from bt_manip.runner.xml_tree import known_behaviours
from bt_manip.spatial import pose

SUCCESS, FAILURE = NodeStatus.SUCCESS, NodeStatus.FAILURE
ABOVE_TABLE = 1.015  # [m]


class Listing(CellBehaviour):
    objects = ObjectInput(list[str], doc="Names of objects.")

    def update(self):
        self.seen = self.objects
        return Status.SUCCESS


@pytest.fixture
def cell(station):
    """A cell with three cubes on the table, of which the last is small, and a box."""
    for i, size in enumerate((0.05, 0.05, 0.03), 1):
        height = ABOVE_TABLE + size / 2
        station.cell.add(Cube(size=size), pose((0.3, 0.15 * i - 0.3, height)), name=f"part_{i}")
    station.cell.add(Box(), pose((0.1, 0.3, ABOVE_TABLE + 0.02)), name="carton")
    return station.cell


def test_patterns_and_kinds_stand_for_the_objects_of_the_cell(station, cell, trial):
    for text, names in (
        ("part_*", ["part_1", "part_2", "part_3"]),
        ("kind:cube", ["cube", "part_1", "part_2", "part_3"]),
        ("part_?;carton", ["part_1", "part_2", "part_3", "carton"]),
        ("part_3;part_*", ["part_3", "part_1", "part_2"]),
        ("kind:box;carton", ["carton"]),
        ("carton;cube", ["carton", "cube"]),
        ("", []),
    ):
        one = Listing(objects=text)
        trial(one).tick_until("SUCCESS", timeout=1.0)
        assert one.seen == names


def test_a_pattern_without_an_object_names_what_there_is(station, cell):
    for text in ("bolt_*", "kind:bolt"):
        with pytest.raises(NodeError, match=rf"no object is called '{text[:4]}.*part_1 \(cube\), "):
            Tree(Listing(objects=text)).setup(**station.infrastructure)
        with pytest.raises(NodeError, match="carton .box."):
            goal = IsIn(object=text, container="basket")
            Tree(AlwaysSuccess(), goal=goal).setup(**station.infrastructure)


def test_a_pattern_keeps_the_objects_of_the_set_up_and_an_entry_those_of_now(station, cell):
    fixed, read = Listing("fixed", objects="part_*"), Listing("read", objects="{names}")
    tree = Tree(Sequence("both", fixed, read))
    tree.blackboard.set_text("names", "part_*")
    tree.setup(**station.infrastructure)
    cell.add(Cube(), pose((0.1, 0.1, ABOVE_TABLE + 0.025)), name="part_9")
    tree.tick()
    assert fixed.seen == ["part_1", "part_2", "part_3"]
    assert read.seen == ["part_1", "part_2", "part_3", "part_9"]


def test_a_condition_holds_if_it_holds_for_each_object(station, cell, trial):
    cell.step(300)
    assert trial(IsOn(object="part_*", support="table")).tick() is SUCCESS
    cell.move("part_2", pose((0.3, 0.0, 1.4)))
    assert trial(IsOn(object="part_*", support="table")).fails_with("'part_2'")
    assert trial(IsOn(object="part_1", support="table")).tick() is SUCCESS


def test_a_goal_for_several_objects_is_one_for_each(station, cell, parts):
    goal = IsOn(object="part_?", support="table")
    tree = Tree(AlwaysSuccess(), goal=goal, tree_id="Main")
    tree.setup(**station.infrastructure)
    text = tree_to_xml(tree, known_behaviours(parts))
    assert '_goal="IsOn object=part_? support=table"' in text  # as it was given
    assert [one.object for one in tree.goal] == ["part_1", "part_2", "part_3"]
    cell.step(300)
    judge = GoalJudge(tree, cell)
    judge.begin()
    assert judge.why_not() == ""
    cell.move("part_3", pose((0.3, 0.15, 1.4)))
    assert [bool(reason) for reason in judge.reasons()] == [False, False, True]
    cell.move("part_3", pose((0.3, 0.15, ABOVE_TABLE + 0.015)))
    cell.step(300)
    cell.remove("part_1")  # each is judged before it is removed
    assert judge.end(True, "") == (True, "")


def test_a_question_for_one_object_takes_no_pattern(station, cell, trial):
    assert trial(ObjectExists(object="part_*")).tick() is FAILURE
    assert trial(IsHolding(object="part_*")).fails_with("holds nothing")
