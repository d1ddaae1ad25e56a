"""Behaviours of two robots in one cell: they wait for each other."""

import mujoco
import pytest

from bt_manip import spatial
from bt_manip.behaviours import MoveToPose, pose_to_text
from bt_manip.bt import NodeStatus

from .conftest import set_up

MIDDLE = spatial.pointing_down((0.0, 0.0, 1.2))


def test_behaviour_waits_until_the_other_robot_has_left(station, left, right):
    left.arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not left.arm.moving)
    waiting = set_up(station, MoveToPose(robot="right", pose=pose_to_text(MIDDLE)))
    for _ in range(50):
        assert waiting.tick() is NodeStatus.RUNNING
    assert "waiting: 'left' blocks" in waiting.behaviour.feedback_message
    assert not right.arm.moving
    left.arm.move_to_configuration(left.robot.description.home)
    assert waiting.until_done(6.0) is NodeStatus.SUCCESS


def test_behaviour_fails_when_the_other_robot_stays_longer_than_it_waits(station, left):
    left.arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not left.arm.moving)
    for wait in (0.0, 0.5):
        start = station.cell.time
        impatient = MoveToPose(robot="right", pose=pose_to_text(MIDDLE), wait=wait)
        assert set_up(station, impatient).fails_with("'left' blocks")
        assert station.cell.time - start == pytest.approx(wait, abs=0.02)


def test_contact_between_fingers_of_two_robots_is_no_grip(station, left, right):
    cell = station.cell
    for robot, y in ((left, 0.004), (right, -0.004)):
        away = spatial.pointing_down((0.0, y, 1.3), 0.0)
        found = robot.arm.ik.nearest(away, robot.robot.q)
        assert found.solved
        robot.robot.set_configuration(found.q)
    mujoco.mj_forward(cell.model, cell.data)
    pairs = cell.contact_monitor.summary().unexpected
    assert any({a.split("/")[0], b.split("/")[0]} == {"left", "right"} for a, b in pairs)
    assert any(all("finger" in body for body in pair) for pair in pairs)
