"""Other arms than the Panda, with and without a gripper."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm, ExternalForceGuard
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld
from bt_manip.control import ComputedTorque
from bt_manip.exceptions import MotionError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, read_description
from bt_manip.trajectories import limit_use
from tests.robot_fixtures import Box, menagerie_robot


def test_arm_without_a_gripper_checks_collisions_and_external_forces(menagerie):
    limits = {"acceleration": 6.0, "jerk": 3000.0, "effort": 200.0}
    described = menagerie_robot(menagerie, "ur5e", **limits).description
    robot = Robot(replace(described, home=(0.1, -1.2, 1.2, -1.5, -1.5, 0.1)))
    control = ComputedTorque(robot)
    robot.attach(control)
    cell = Cell()
    cell.add(robot, spatial.pose((0.0, 0.0, 1.0)), free=False)
    model = robot.make_model()
    world, guard = CollisionWorld(robot, model), ExternalForceGuard(robot, model)
    arm = control.reference = Arm(robot, model=model, world=world, guard=guard)
    ahead = model.pose(arm.q) * spatial.pose((0.0, 0.0, 0.1))
    cell.add(Box((0.04, 0.04, 0.04)), ahead, name="block")
    with pytest.raises(MotionError, match="'block'"):
        arm.move_linear(ahead)
    cell.remove("block")
    arm.move_linear(model.pose(arm.q) * spatial.pose((0.0, 0.0, -0.1)))
    while arm.moving:
        cell.step()
    arm.move_to_configuration(arm.q + 0.3)
    cell.step(200)
    assert arm.moving and not arm.fault
    cell.data.xfrc_applied[robot.wrist_body_id][:3] = (0.0, 60.0, 0.0)
    cell.step(20)
    assert arm.fault.startswith("external force on the arm:")


def test_an_arm_on_a_rail_follows_a_line_along_the_rail(rail_robot):
    arm = Arm(rail_robot)
    with pytest.raises(MotionError, match=r"joint 1 cannot go to 0.7000 m: .* -0.6000 to 0.6000 m"):
        arm.move_to_configuration([0.7, *arm.q[1:]])
    T = spatial.pointing_down([0.5, -0.4, 0.3])
    arm.reset(arm.ik.nearest(T, arm.model.home).q)
    target = pin.SE3(T.rotation, T.translation + [0.0, 0.8, 0.0])
    arm.move_linear(target)
    assert limit_use(arm.trajectory, arm.model.limits).inside
    while arm.moving:
        arm.advance(1e-3)
        assert np.linalg.norm((arm.model.pose(arm.q).translation - T.translation)[[0, 2]]) < 1e-4
    assert np.abs(pin.log6(target.actInv(arm.model.pose(arm.q))).np).max() < 1e-5


def test_an_arm_on_a_rail_does_not_drive_into_an_obstacle():
    description = read_description(Path(__file__).parents[1] / "robots/models/rail.toml")
    cell, robot = Cell(), Robot(description, gripper=TwoFingerGripper)
    cell.add(robot, spatial.pose((0.0, 0.0, 1.0)), free=False)
    cell.add(Box((0.1, 0.04, 1.6)), spatial.pose((0.0, 0.35, 1.9)), name="post")
    model = robot.make_model()
    arm = Arm(robot, model=model, world=CollisionWorld(robot, model))
    with pytest.raises(MotionError, match="'post'"):
        arm.move_to_configuration([0.35, *arm.q[1:]])
    arm.move_to_configuration([-0.35, *arm.q[1:]])
