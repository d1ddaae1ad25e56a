"""Behaviours that move the arm: they arrive, or say why not, and brake when halted."""

from functools import partial

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.behaviours import (
    Hover,
    IsAt,
    IsHolding,
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


def test_from_over_the_object_reach_goes_straight_down_around_it_without_touching_it(
    station, trial
):
    before = station.cell.pose("cube")
    hovering = trial(Hover(object="cube", height=0.15))
    assert hovering.tick() is RUNNING
    assert "s left" in hovering.behaviour.feedback_message
    assert hovering.until_done() is SUCCESS
    message = hovering.behaviour.feedback_message
    assert "from above, 50 mm wide" in message
    assert "rad from the nearest joint limit; " in message
    assert "s away at full joint speed" in message
    over = station.robot.tool_pose
    assert over.translation == pytest.approx(before.translation + [0, 0, 0.15], abs=2e-3)
    assert over.rotation[:, 2] == pytest.approx([0, 0, -1], abs=5e-3)
    line = over.translation[:2]
    reaching = trial(Reach(object="cube"))
    while reaching.tick() is RUNNING:
        assert station.robot.tool_pose.translation[:2] == pytest.approx(line, abs=1e-3)
    assert station.cell.contact_monitor.summary().held == ()
    moved = before.actInv(station.cell.pose("cube")).translation
    assert np.linalg.norm(moved) < 1e-5
    moved = over.actInv(station.robot.tool_pose)
    assert moved.translation == pytest.approx([0.0, 0.0, 0.135], abs=2e-3)
    assert np.abs(pin.log3(moved.rotation)).max() < 5e-3


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


@pytest.mark.parametrize("move", [MoveToPose, MoveLinear, partial(MoveToPose, linear=True)])
def test_a_motion_or_line_ends_at_the_nearest_turn_about_a_free_axis(station, trial, move):
    start = station.robot.tool_pose
    target = start * pin.SE3(pin.utils.rotate("z", 2.5), np.array([0.05, 0.0, 0.08]))
    moving = trial(move(pose=target, free_axis="z"))
    along = (target.translation - start.translation) / np.sqrt(0.05**2 + 0.08**2)
    while moving.tick() is RUNNING:
        gone = station.robot.tool_pose.translation - start.translation
        assert move is MoveToPose or np.linalg.norm(gone - (gone @ along) * along) < 2e-3
    tool = station.robot.tool_pose
    assert tool.translation == pytest.approx(target.translation, abs=2e-3)
    assert tool.rotation[:, 2] == pytest.approx(target.rotation[:, 2], abs=5e-3)
    assert tool_error(station, target)[1] > 1.0


def test_with_all_rotations_free_only_the_position_is_reached(station, trial):
    target = pin.SE3(np.eye(3), station.robot.tool_pose.translation + [0.05, 0.0, 0.0])
    assert trial(MoveToPose(pose=target, free_axis="all")).until_done() is SUCCESS
    distance, angle = tool_error(station, target)
    assert distance < 2e-3 and angle > 1.0


def test_motions_to_configurations_arrive_later_at_a_lower_speed(station, trial):
    def duration(behaviour, q):
        began = station.cell.time
        assert trial(behaviour).until_done(6) is SUCCESS
        assert station.robot.q == pytest.approx(q, abs=2e-3)
        return station.cell.time - began

    slow = duration(MoveToConfiguration(configuration=NEAR_HOME, speed=0.25), NEAR_HOME)
    duration(MoveHome(), HOME)
    assert slow > 1.5 * duration(MoveToConfiguration(configuration=NEAR_HOME), NEAR_HOME)


def test_an_arm_that_something_holds_fails_unless_it_is_within_a_wide_tolerance(
    station, trial, monkeypatch
):
    monkeypatch.setattr(station.arm, "guard", None)  # which would stop it before
    moving = trial(MoveToConfiguration(configuration=NEAR_HOME))
    hand = station.cell.body_id("panda/hand")
    assert moving.tick() is RUNNING
    began, planned = station.cell.time, station.arm.remaining
    station.cell.data.xfrc_applied[hand] = [0, 400.0, 0, 0, 0, 0]
    assert moving.fails_with("from its target: external force on the arm")
    assert station.cell.time - began == pytest.approx(planned + 0.5, abs=0.03)  # it settles first
    tolerant = trial(MoveToConfiguration(configuration=NEAR_HOME, tolerance=3.0))
    assert tolerant.until_done() is SUCCESS


def test_is_at_says_how_far_away_the_tool_is(station, trial):
    there, (x, y, z) = station.robot.tool_pose, np.eye(3)
    for offset, rotation, message in (
        (0.0 * z, 0.005 * x, ""),
        (0.02 * z, 0.0 * x, "20.0 mm"),
        (0.0 * z, 0.02 * y, "0.0 mm and 0.020 rad away"),
        (0.0 * z, np.pi * z, "0.0 mm and 3.142 rad away"),
    ):
        pose = pin.SE3(there.rotation @ pin.exp3(rotation), there.translation + offset)
        asked = trial(IsAt(pose=pose))
        assert asked.fails_with(message) if message else asked.tick() is SUCCESS


def test_a_tool_that_moves_through_a_pose_is_not_at_it(station, trial):
    moving = trial(MoveToConfiguration(configuration=NEAR_HOME))
    for _ in range(10):
        assert moving.tick() is RUNNING
        station.cell.step(10)
    assert trial(IsAt(pose=station.robot.tool_pose)).fails_with("the tool moves")


def test_the_progress_to_a_pose_or_an_object_falls_to_one_eth_within_30_cm(station, trial):
    tool = station.robot.tool_pose.translation
    at = trial(IsAt(pose=spatial.pose(tool + [0.1, -0.2, 0.2]))).behaviour
    assert at.progress() == pytest.approx(np.exp(-1.0))
    away = np.linalg.norm(tool - station.cell.pose("cube").translation)
    holding = trial(IsHolding(object="cube")).behaviour
    assert holding.progress() == pytest.approx(np.exp(-away / 0.3))
