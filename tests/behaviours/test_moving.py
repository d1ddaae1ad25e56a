"""Behaviours that move the arm: they arrive, or say why not, and brake when halted."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.behaviours import (
    Hover,
    IsAt,
    Lift,
    MoveHome,
    MoveLinear,
    MoveToConfiguration,
    MoveToPose,
    Reach,
    pose_to_text,
)
from bt_manip.bt import NodeStatus
from bt_manip.cell.objects import Box

RUNNING, SUCCESS, FAILURE = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE
HOME = (0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, np.pi / 2, np.pi / 4)
NEAR_HOME = [0.1, -0.6, 0.1, -2.2, 0.1, 1.6, 0.9]


def tool_error(station, T_wt):
    """Measure how far the simulated tool is from a pose: distance [m] and angle [rad]."""
    error = station.robot.tool_pose.actInv(T_wt)
    return np.linalg.norm(error.translation), np.linalg.norm(pin.log3(error.rotation))


def test_hover_ends_over_the_object_pointing_down(station, trial):
    assert trial(Hover(object="cube", height=0.3)).until_done() is SUCCESS
    tool = station.robot.tool_pose
    assert tool.translation == pytest.approx(
        station.cell.pose("cube").translation + [0, 0, 0.3], abs=2e-3
    )
    assert tool.rotation[:, 2] == pytest.approx([0, 0, -1], abs=5e-3)


def test_reach_goes_straight_down_around_the_object_without_touching_it(station, trial):
    before = station.cell.pose("cube")
    hovering = trial(Hover(object="cube", height=0.15))
    assert hovering.tick() is RUNNING
    assert "s left" in hovering.behaviour.feedback_message
    assert hovering.until_done() is SUCCESS
    line = station.robot.tool_pose.translation[:2]
    reaching = trial(Reach(object="cube"))
    while reaching.tick() is RUNNING:
        assert station.robot.tool_pose.translation[:2] == pytest.approx(line, abs=1e-3)
    assert station.cell.contact_monitor.summary().held == ()
    moved = before.actInv(station.cell.pose("cube")).translation
    assert np.linalg.norm(moved) < 1e-5
    assert station.robot.tool_pose.translation == pytest.approx(
        before.translation + [0, 0, 0.015], abs=2e-3
    )


def test_lift_raises_the_tool_straight_up(station, trial):
    before = station.robot.tool_pose
    assert trial(Lift(height=0.05)).until_done() is SUCCESS
    target = pin.SE3(before.rotation, before.translation + [0, 0, 0.05])
    distance, angle = tool_error(station, target)
    assert distance < 2e-3 and angle < 5e-3


@pytest.mark.parametrize("automatic", [{}, {"height": 0.25, "least": 0.03}])
def test_a_lift_with_a_choice_of_heights_ends_below_an_obstacle(station, trial, automatic):
    before = station.robot.tool_pose.translation
    shelf = spatial.pose(before + [0.0, 0.13, 0.3])
    station.cell.add(Box(size=(0.1, 0.1, 0.02)), shelf, name="shelf", free=False)
    assert trial(Lift(height=0.25, least=0.2)).fails_with("'shelf'")
    assert trial(Lift(**automatic)).until_done() is SUCCESS
    assert 0.03 < station.robot.tool_pose.translation[2] - before[2] < 0.25


def test_move_to_pose_arrives_at_the_pose(station, trial):
    target = spatial.pointing_down((0.35, -0.2, 1.3), 0.4)
    assert trial(MoveToPose(pose=pose_to_text(target))).until_done() is SUCCESS
    distance, angle = tool_error(station, target)
    assert distance < 2e-3 and angle < 5e-3
    assert trial(IsAt(pose=target, position_tolerance=2e-3)).tick() is SUCCESS


def test_about_a_free_axis_the_tool_turns_as_little_as_the_arm_likes(station, trial):
    target = station.robot.tool_pose * pin.SE3(pin.utils.rotate("z", 2.0), np.array([0, 0, 0.05]))
    assert trial(MoveToPose(pose=target, free_axis="z")).until_done() is SUCCESS
    tool = station.robot.tool_pose
    assert tool.translation == pytest.approx(target.translation, abs=2e-3)
    assert tool.rotation[:, 2] == pytest.approx(target.rotation[:, 2], abs=5e-3)
    assert tool_error(station, target)[1] > 1.0


@pytest.mark.parametrize("move", [MoveLinear, partial(MoveToPose, linear=True)])
def test_a_line_ends_at_the_nearest_turn_about_a_free_axis(station, trial, move):
    start = station.robot.tool_pose
    target = start * pin.SE3(pin.utils.rotate("z", 2.5), np.array([0.05, 0.0, 0.08]))
    moving = trial(move(pose=target, free_axis="z"))
    along = (target.translation - start.translation) / np.sqrt(0.05**2 + 0.08**2)
    while moving.tick() is RUNNING:
        gone = station.robot.tool_pose.translation - start.translation
        assert np.linalg.norm(gone - (gone @ along) * along) < 2e-3
    tool = station.robot.tool_pose
    assert tool.translation == pytest.approx(target.translation, abs=2e-3)
    assert tool.rotation[:, 2] == pytest.approx(target.rotation[:, 2], abs=5e-3)
    assert tool_error(station, target)[1] > 1.0


def test_with_all_rotations_free_only_the_position_is_reached(station, trial):
    target = pin.SE3(np.eye(3), station.robot.tool_pose.translation + [0.05, 0.0, 0.0])
    assert trial(MoveToPose(pose=target, free_axis="all")).until_done() is SUCCESS
    distance, angle = tool_error(station, target)
    assert distance < 2e-3 and angle > 1.0


def test_move_to_configuration_is_slower_at_a_lower_speed(station, trial):
    def duration(speed):
        began = station.cell.time
        moving = trial(MoveToConfiguration(configuration=NEAR_HOME, speed=speed))
        assert moving.until_done(6) is SUCCESS
        return station.cell.time - began

    slow = duration(0.25)
    trial(MoveHome()).until_done()
    assert slow > 1.5 * duration(1.0)


def test_motions_to_configurations_arrive(station, trial):
    for behaviour, q in (
        (MoveToConfiguration(configuration=NEAR_HOME), NEAR_HOME), (MoveHome(), HOME),
    ):  # fmt: skip
        assert trial(behaviour).until_done() is SUCCESS
        assert station.robot.q == pytest.approx(q, abs=2e-3)


def test_an_arm_that_something_holds_fails_unless_it_is_within_a_wide_tolerance(
    station, trial, monkeypatch
):
    monkeypatch.setattr(station.arm, "guard", None)  # which would stop it before
    moving = trial(MoveToConfiguration(configuration=NEAR_HOME))
    hand = station.cell.body_id("panda/hand")
    assert moving.tick() is RUNNING
    station.cell.data.xfrc_applied[hand] = [0, 400.0, 0, 0, 0, 0]
    assert moving.fails_with("from its target: external force on the arm")
    tolerant = trial(MoveToConfiguration(configuration=NEAR_HOME, tolerance=3.0))
    assert tolerant.until_done() is SUCCESS


def test_is_at_says_how_far_away_the_tool_is(station, trial):
    there = station.robot.tool_pose
    assert trial(IsAt(pose=there)).tick() is SUCCESS
    beside = pin.SE3(there.rotation, there.translation + [0, 0, 0.02])
    assert trial(IsAt(pose=beside)).fails_with("20.0 mm")


def test_a_turned_tool_is_not_at_a_pose(station, trial):
    there = station.robot.tool_pose
    axes = np.eye(3)
    for axis, angle, at in (
        (axes[0], 0.005, True),
        (axes[1], 0.02, False),
        (axes[2], np.pi, False),
    ):
        turned = pin.SE3(there.rotation @ pin.exp3(angle * axis), there.translation)
        asked = trial(IsAt(pose=turned))
        if at:
            assert asked.tick() is SUCCESS
        else:
            assert asked.fails_with(f"0.0 mm and {angle:.3f} rad away")


def test_a_tool_that_moves_through_a_pose_is_not_at_it(station, trial):
    moving = trial(MoveToConfiguration(configuration=NEAR_HOME))
    for _ in range(10):
        assert moving.tick() is RUNNING
        station.cell.step(10)
    assert trial(IsAt(pose=station.robot.tool_pose)).fails_with("the tool moves")


def test_the_progress_to_a_pose_rises_from_0_to_1():
    def progress(distance):
        robot = SimpleNamespace(tool_pose=spatial.pose((distance, 0.0, 0.0)))
        arm = SimpleNamespace(robot=robot)
        return IsAt.progress(SimpleNamespace(arm=arm, pose=spatial.pose((0.0, 0.0, 0.0))))

    assert progress(0.0) == 1.0
    assert 1.0 > progress(0.05) > progress(0.5) > 0.0
