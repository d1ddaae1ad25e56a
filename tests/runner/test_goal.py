"""The goal of a tree is judged from the physics, before objects are removed and at the end."""

import pytest

from bt_manip import spatial
from bt_manip.behaviours import IsIn, IsOn, ObjectExists, RemoveObject, SpawnObject
from bt_manip.bt import AlwaysSuccess, Sequence, SetBlackboard, Sleep, Tree
from bt_manip.cell import Cube
from bt_manip.runner import GoalJudge
from tests.support.notebook import built as built
from tests.support.notebook import station as station

FLOOR = "0.3;0.31;0.1;0.11"
IN_BASKET = spatial.pose((0.68, 0.0, 1.08))


@pytest.fixture
def cell(station):
    return station.cell


def run(station, *children, goal):
    return station.run(Tree(Sequence("task", *children), goal=goal))


def spawn():
    return SpawnObject(region=FLOOR, object="{object}")


def goal():
    return IsIn(object="{object}", container="basket")


def on_the_table():
    return IsOn(object="{object}", support="table")


def test_success_with_the_cube_on_the_table_is_a_failure_unless_that_is_the_goal(station):
    result = run(station, spawn(), Sleep(msec=300), goal=goal())
    assert str(result) == "FAILURE: goal not met: 'cube' touches 'table'"
    on, inside = IsOn(object="cube", support="table"), IsIn(object="cube", container="basket")
    assert str(run(station, AlwaysSuccess(), goal=on)) == "SUCCESS"
    result = run(station, AlwaysSuccess(), goal=[on, inside])
    assert "goal not met: 'cube' touches 'table'" in str(result)  # all conditions must hold


def test_the_state_of_a_judge_does_not_change_when_it_judges_again(cell):
    cell.add(Cube(), spatial.pose((0.3, 0.1, 1.041)), name="cube")
    judge = GoalJudge(Tree(Sleep(msec=1), goal=IsIn(object="cube", container="basket")), cell)
    judge.begin()
    state = judge.get_state()
    cell.remove("cube")
    judge.stop()
    assert state["kept"] == [[]] != judge.get_state()["kept"]


def test_an_object_is_judged_before_it_is_removed(station):
    result = run(station, spawn(), RemoveObject(object="{object}"), goal=goal())
    assert str(result) == "FAILURE: goal not met: 'cube' touches 'table'"
    result = run(station, spawn(), RemoveObject(object="{object}"), goal=on_the_table())
    assert str(result) == "SUCCESS"


def test_each_object_of_one_name_counts(cell, station):
    def replaced():
        known = SetBlackboard(value="cube", output_key="object")
        return known, RemoveObject(object="cube"), spawn(), Sleep(msec=300)

    cell.add(Cube(), IN_BASKET, name="cube")
    cell.step(500)
    result = run(station, *replaced(), goal=goal())
    assert str(result) == "FAILURE: goal not met: 'cube' touches 'table'"
    assert str(run(station, *replaced(), goal=on_the_table())) == "SUCCESS"


def test_what_was_judged_is_not_judged_again_when_the_container_goes(cell, station):
    tree = Tree(AlwaysSuccess(), clock=station.clock, goal=goal())
    tree.setup(**station.infrastructure)
    tree.blackboard["object"] = "cube"
    cell.add(Cube(), IN_BASKET, name="cube")
    cell.step(500)
    judge = GoalJudge(tree, cell)
    judge.begin()
    cell.remove("cube")
    cell.remove("basket")
    assert judge.end(True, "") == (True, "")


@pytest.mark.parametrize(
    ("object", "reason"),
    [("{nobody}", "the blackboard entry 'nobody' does not exist"), ("ball", "'ball'")],
)
def test_a_condition_that_cannot_be_evaluated_does_not_hold(station, object, reason):
    where = IsIn(object=object, container="basket")
    result = run(station, AlwaysSuccess(), goal=where)
    assert result.reason.startswith("goal not met: ") and reason in result.reason
    failed = run(station, ObjectExists("look", object="ball"), goal=where)
    assert failed.reason.startswith("look: ")  # a failed tree keeps its reason


def test_judging_changes_neither_blackboard_nor_cell(station):
    tree = Tree(AlwaysSuccess(), clock=station.clock,
                goal=IsIn(object="{object}", container="{container}"))  # fmt: skip
    before = tree.get_state(), station.cell.state_bytes()
    assert not station.cell.before_remove
    station.run(tree)
    assert (tree.get_state(), station.cell.state_bytes()) == before
    assert not station.cell.before_remove


def test_what_was_judged_is_part_of_the_state(cell, station):
    tree = Tree(AlwaysSuccess(), clock=station.clock, goal=goal())
    resumed = GoalJudge(tree, cell)
    tree.setup(**station.infrastructure)  # it makes the conditions of the goal
    tree.blackboard["object"] = "cube"
    cell.add(Cube(), spatial.pose((0.3, 0.1, 1.04)), name="cube")
    cell.step(200)
    judge = GoalJudge(tree, cell)
    judge.begin(3)
    cell.remove("cube")
    resumed.set_state(judge.get_state())
    judge.stop()
    resumed.begin(3)
    assert resumed.end(True, "") == (False, "goal not met: 'cube' touches 'table'")
    assert resumed.holds is False
    resumed.begin(4)
    assert "'cube'" in resumed.end(True, "")[1]


def test_a_restored_judge_knows_what_was_gripped_in_this_cycle(cell):
    tree = Tree(Sleep(msec=1), goal=IsIn(object="cube", container="basket"))
    cell.add(Cube(), IN_BASKET, name="cube")
    judge, restored = GoalJudge(tree, cell), GoalJudge(tree, cell)
    judge.begin(4)
    judge.grip("cube", "left")
    judge.grip("cube", "right")
    restored.set_state(judge.get_state())
    restored.begin(4)
    assert [(one.name, one.robot) for one in restored.gripped] == [("cube", "right")]
    cell.remove("cube")
    (one,) = restored.gripped
    assert one.removed and one.placed is not None
    restored.begin(5)
    assert restored.gripped == []
    for each in (judge, restored):
        each.stop()
