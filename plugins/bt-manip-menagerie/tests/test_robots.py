"""Each robot is the one that is simulated, and its gripper holds what it grips."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.behaviours import nearest_orientation, payload_of, top_grasp_poses
from bt_manip.cell.objects import Cube
from bt_manip.spatial import pose

CUBE = (0.3, 0.05, 1.015 + 0.025)  # [m] on the table


def fingers_gap(station) -> float:
    """Measure the opening on the shapes themselves [m]."""
    model, data = station.cell.model, station.cell.data
    left, right = station.robot.gripper.mechanism.geoms
    return min(mujoco.mj_geomDistance(model, data, a, b, 1.0, None) for a in left for b in right)


def tool_to_cube(station) -> pin.SE3:
    mujoco.mj_forward(station.cell.model, station.cell.data)
    return station.robot.tool_pose.actInv(station.cell.pose("cube"))


def test_home_is_well_inside_the_limits(station):
    home = np.array(station.robot.description.home)
    assert station.robot.limits.contain(home, tolerance=-0.05)


def test_the_gripper_opens_as_wide_as_it_says(station):
    for share in (0.9, 0.2):
        width = share * station.robot.gripper.mechanism.travel.open_width
        station.gripper.move(width)
        station.step_until(lambda: not station.gripper.moving, timeout=2.0)
        station.cell.step(100)
        assert station.gripper.width == pytest.approx(width, abs=5e-4)
        assert fingers_gap(station) == pytest.approx(width, abs=1.5e-3)
    station.gripper.open()
    station.step_until(lambda: station.gripper.is_open, timeout=3.0)


def test_it_picks_a_cube_and_holds_it_by_friction(station):
    """The cube rests 15 mm under the tool, does not sink in, creep or turn, and is set free."""
    cell, arm, gripper = station.cell, station.arm, station.gripper
    equalities = cell.model.neq
    cell.add(Cube(friction=0.8), pose(CUBE), name="cube")
    cell.step(100)
    arm.move_to_pose(top_grasp_poses(cell.pose("cube"), 0.25), approach=0.235)
    station.step_until(lambda: not arm.moving)
    grip = nearest_orientation(top_grasp_poses(cell.pose("cube"), 0.015), arm.model.pose(arm.q))
    arm.move_linear(grip)
    station.step_until(lambda: not arm.moving)
    gripper.close(50.0)
    station.step_until(lambda: gripper.steady, timeout=2.0)
    assert gripper.held == ("cube",)
    arm.payload = payload_of(cell, "cube", station.robot.tool_pose)
    arm.move_linear(pin.SE3(grip.rotation, grip.translation + np.array([0.0, 0.0, 0.2])))
    station.step_until(lambda: not arm.moving)
    cell.step(300)
    before, deepest = tool_to_cube(station), 0.0
    for _ in range(500):
        cell.step()
        deepest = min(deepest, cell.data.contact.dist.min(initial=0.0))
    contact = cell.data.contact
    roots = cell.model.body_rootid[cell.model.geom_bodyid[contact.geom]]  # (ncon, 2)
    of_the_cube = (roots == cell.body_id("cube")).any(axis=1)
    assert set(contact.friction[of_the_cube, 0]) == {0.8}
    moved = before.actInv(tool_to_cube(station))
    assert np.allclose(gripper.forces, 50.0, rtol=0.05)
    assert -deepest < 0.5e-3  # [m]
    assert np.linalg.norm(moved.translation) / 0.5 < 0.1e-3  # [m/s]
    assert np.linalg.norm(pin.log3(moved.rotation)) / 0.5 < 2e-3  # [rad/s]
    assert cell.model.neq == equalities
    assert station.controller.saturated_steps == 0
    gripper.open()
    station.step_until(lambda: gripper.is_free and gripper.is_open, timeout=2.0)
    arm.payload = None
    cell.remove("cube")
