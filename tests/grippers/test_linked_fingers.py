"""A gripper of linkages under one motor, through the same controller as two slides."""

import dataclasses
from pathlib import Path

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell, Cube
from bt_manip.control import ComputedTorque, Hold
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, read_description
from bt_manip.spatial import pose
from tests.support.arms import step_until

FILE = Path(__file__).parents[1] / "robots" / "models" / "post.toml"


def make(cube=True):
    """Let the gripper hang over a cube that stands on the floor."""
    robot = Robot(
        dataclasses.replace(read_description(FILE), pedestal=None), gripper=TwoFingerGripper
    )
    control, gripper = ComputedTorque(robot), robot.gripper
    robot.attach(control)
    cell = Cell()
    # The tool, 580 mm above the robot's place, comes 10 mm over the middle of the cube.
    cell.add(robot, pose((0.4, 0.0, 0.035 - 0.58)), free=False)
    if cube:
        cell.add(Cube(), pose((0.0, 0.003, 0.025)))
    control.reference = Hold(robot.q)
    return cell, control, gripper


def gap(cell, gripper):
    mujoco.mj_forward(cell.model, cell.data)
    left, right = gripper.mechanism.geoms
    return mujoco.mj_geomDistance(cell.model, cell.data, left[0], right[0], 1.0, None)


def test_the_opening_is_the_distance_of_the_fingers_down_to_none():
    cell, _, gripper = make(cube=False)
    for width in (0.09, 0.05, 0.02):
        gripper.move(width)
        step_until(cell, lambda: not gripper.moving)
        cell.step(100)
        assert gripper.width == pytest.approx(width, abs=3e-4)
        assert gap(cell, gripper) == pytest.approx(width, abs=5e-4)
    gripper.close(20.0)
    step_until(cell, lambda: gripper.closed_on_nothing)
    assert not gripper.steady and gripper.held == ()
    gripper.open()
    step_until(cell, lambda: gripper.is_open)


def test_both_fingers_press_off_centre_and_what_they_hold_can_be_lifted_and_let_go():
    cell, control, gripper = make()
    for force in (10.0, 40.0):
        gripper.close(force)
        step_until(cell, lambda: gripper.steady)
        assert gripper.held == ("cube",)
        cell.step(700)
        left, right = gripper.forces
        assert 0.5 * (left + right) == pytest.approx(force, rel=0.01)
        # What the floor's friction carries of the difference; one motor cannot take it away.
        assert left == pytest.approx(right, rel=0.1)
    control.reference = Hold(control.robot.q + np.array([0.1, 0.0]))
    cell.step(1000)
    assert cell.pose("cube").translation[2] > 0.1
    gripper.open()
    step_until(cell, lambda: gripper.is_free and gripper.is_open)
