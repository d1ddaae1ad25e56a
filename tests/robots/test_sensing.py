"""The wrist feels weights computed by hand; the tool moves as its kinematics say."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell
from bt_manip.robots import Robot
from tests.support.arms import TWO_LINKS
from tests.support.arms import description as description

G = 9.81
MOUNTED = """<body name="hand" pos="0.3 0 0"><geom size="0.01" pos="0.1 0 0" mass="0.5"/>
  <body name="palm"><geom size="0.01" pos="0.1 0 0" mass="0.2"/><site name="tip" pos="0.2 0 0"/>
  </body></body>"""
BARE = '<site name="tip" pos="0.3 0 0"/>'


@pytest.fixture
def make(description):
    def make(hand=BARE):
        Path(description.model).write_text(TWO_LINKS.replace(BARE, hand))
        robot = Robot(replace(description, home=(0.0, 0.0)))
        cell = Cell()
        cell.add(robot)
        return cell, robot

    return make


def at_rest(cell, robot):
    """Hold the arm still by exactly the efforts that it takes."""
    cell.data.qvel[:] = 0
    mujoco.mj_forward(cell.model, cell.data)
    cell.data.ctrl[robot.ctrl_adr] = cell.data.qfrc_bias[robot.dof_adr]
    mujoco.mj_forward(cell.model, cell.data)


def test_the_wrist_bears_what_is_mounted_on_it(make):
    cell, robot = make(MOUNTED)
    assert cell.model.body(robot.wrist_body_id).name == "two_links/hand"
    at_rest(cell, robot)
    force, torque = robot.wrist_wrench(pin.SE3.Identity())
    np.testing.assert_allclose(force, (0, 0, 0.7 * G), atol=1e-9)
    # About the world's origin: r x f with r = (0.8, 0, 1).
    np.testing.assert_allclose(torque, (0, -0.8 * 0.7 * G, 0), atol=1e-9)
    # About the tool, 0.1 m beyond the weight: it pulls the other way.
    force, torque = robot.wrist_wrench()
    np.testing.assert_allclose(force, (0, 0, 0.7 * G), atol=1e-9)
    np.testing.assert_allclose(torque, (0, 0.1 * 0.7 * G, 0), atol=1e-9)


def test_the_wrist_feels_what_pulls_from_outside_along_its_frame(make):
    cell, robot = make(MOUNTED)
    robot.set_configuration(np.array([0.0, np.pi / 2]))  # the tool hangs down
    at_rest(cell, robot)
    np.testing.assert_allclose(robot.wrist_wrench().force, (-0.7 * G, 0, 0), atol=1e-9)
    cell.data.xfrc_applied[cell.body_id("two_links/palm"), :3] = (0, 3.0, 0)
    mujoco.mj_forward(cell.model, cell.data)
    # The arm holds against it.
    assert robot.wrist_wrench().force[1] == pytest.approx(-3.0, abs=1e-9)


def test_without_a_hand_the_wrist_is_the_last_link(make):
    cell, robot = make()
    assert cell.model.body(robot.wrist_body_id).name == "two_links/lower"
    at_rest(cell, robot)
    assert robot.wrist_wrench().force[2] == pytest.approx(1.0 * G, abs=1e-9)


def test_the_tools_velocity_is_that_of_its_jacobian(make):
    cell, robot = make(MOUNTED)
    cell.data.qvel[:] = (0.7, -0.4)
    mujoco.mj_forward(cell.model, cell.data)
    expected = robot.make_model().jacobian(robot.q) @ robot.v
    np.testing.assert_allclose(robot.tool_velocity, expected, atol=1e-12)
    assert np.linalg.norm(expected) > 0.1


def test_asking_changes_no_bit(make):
    (cell, robot), (other, _) = make(MOUNTED), make(MOUNTED)
    for _ in range(50):
        cell.step()
        other.step()
        robot.wrist_wrench()
        _ = robot.tool_velocity
    assert cell.state_bytes() == other.state_bytes()
