"""Two robots in one cell: each has its own arm and gripper, and behaviours say which."""

import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.behaviours import (
    Grasp,
    Hover,
    IsHolding,
    MoveHome,
    MoveToConfiguration,
    MoveToPose,
    OpenGripper,
    Reach,
    pose_to_text,
)
from bt_manip.bt import Action, NodeStatus, Sequence, SubTree
from bt_manip.exceptions import BtManipError, MotionError, NodeError
from bt_manip.scenes import Scene, SceneRobot

from .conftest import set_up

MIDDLE = spatial.pointing_down((0.0, 0.0, 1.2))
BESIDE = spatial.pointing_down((0.0, 0.3, 1.2))
ORIGIN = spatial.pose((0.0, 0.0, 0.0))


def test_each_robot_of_a_scene_has_a_name_an_arm_a_controller_and_a_gripper(station):
    assert list(station.robots) == ["left", "right"]
    assert station.robot is station.robots["left"].robot  # the first, for scripts with one robot
    parts = [(r.robot, r.arm, r.controller, r.gripper) for r in station.robots.values()]
    assert all(a is not b for a, b in zip(*parts, strict=True))


def test_each_robot_has_the_description_controller_and_planner_of_the_scene(parts):
    robots = (
        SceneRobot(spatial.pose((-0.6, 0.0, 0.0)), "old", controller="gravity_compensated_pd"),
        SceneRobot(spatial.pose((0.6, 0.0, 0.0)), "new", description="panda"),
    )
    made = build_station(parts, scene=Scene(robots)).robots
    assert [robot.controller.kind for robot in made.values()] == [
        "gravity_compensated_pd",
        "computed_torque",
    ]


@pytest.mark.parametrize(
    ("robots", "message"),
    [
        ((), "at least one robot"),
        ((SceneRobot(ORIGIN), SceneRobot(ORIGIN)), "each needs a name"),
        ((SceneRobot(ORIGIN, "a"), SceneRobot(ORIGIN, "a")), "two robots .* called 'a'"),
    ],
)
def test_robots_that_cannot_be_told_apart_are_refused(robots, message):
    with pytest.raises(BtManipError, match=message):
        Scene(robots)


def test_a_behaviour_that_takes_the_only_arm_is_refused_where_there_are_two(station):
    class Wave(Action):
        def setup(self, *, arm, **_):
            self.arm = arm

        def initialise(self):
            self.arm.stop()

    with pytest.raises((BtManipError, NodeError), match="robots 'left', 'right', and this"):
        set_up(station, Wave()).tick()


def test_a_robot_that_does_not_exist_is_refused_with_the_nearest_name(station):
    for leaf in (MoveHome(robot="lefft"), IsHolding(object="cube", robot="lefft")):
        with pytest.raises((BtManipError, NodeError), match=r"'lefft'; did you mean 'left'"):
            set_up(station, leaf)


def test_a_single_robot_need_not_be_named_and_another_name_is_wrong(parts):
    alone = build_station(parts)
    assert set_up(alone, OpenGripper()).until_done() is NodeStatus.SUCCESS
    assert set_up(alone, OpenGripper(robot="panda")).until_done() is NodeStatus.SUCCESS
    with pytest.raises((BtManipError, NodeError), match="no robot 'left'; known: panda"):
        set_up(alone, OpenGripper(robot="left"))


def test_a_sub_tree_is_of_the_robot_that_it_is_given(station, left, right):
    home = left.robot.q
    inner = Sequence("inner", [MoveToPose(pose=pose_to_text(BESIDE))])
    trial = set_up(station, SubTree("of the right one", inner, robot="right"))
    assert trial.until_done(5.0) is NodeStatus.SUCCESS
    assert np.linalg.norm(right.robot.tool_pose.translation - BESIDE.translation) < 2e-3
    assert np.abs(left.robot.q - home).max() < 1e-3 and not left.arm.busy


def test_the_robot_may_be_an_entry_that_is_only_written_later(station, right):
    there = right.robot.q + 0.1
    trial = set_up(station, MoveToConfiguration(robot="{whose}", configuration=list(there)))
    trial.blackboard["whose"] = "right"
    assert trial.until_done(5.0) is NodeStatus.SUCCESS
    assert right.robot.q == pytest.approx(there, abs=5e-3)
    trial.blackboard["whose"] = "rihgt"
    assert trial.fails_with("'rihgt'", "did you mean 'right'")


def test_what_one_holds_the_other_does_not_and_it_is_an_obstacle_to_it(station, left, right):
    pick = [leaf(object="cube", robot="left") for leaf in (Hover, Reach, Grasp)]
    assert set_up(station, Sequence("pick", pick)).until_done(9.0) is NodeStatus.SUCCESS
    assert left.gripper.held == ("cube",) and right.gripper.held == ()
    assert left.arm.payload is not None and right.arm.payload is None
    holding = {name: IsHolding(object="cube", robot=name) for name in ("left", "right")}
    assert set_up(station, holding["left"]).until_done() is NodeStatus.SUCCESS
    assert set_up(station, holding["right"]).fails_with("holds nothing")
    left.arm.move_linear(MIDDLE)  # where it holds the cube up: 30 mm of it below the fingers
    with pytest.raises(MotionError, match="'left' blocks"):
        right.arm.move_to_pose(spatial.pointing_down((0.0, 0.0, 1.1)))
