"""Tiny worlds for control: an arm of two links, and the Panda over a cube on a post."""

import mujoco
import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip.cell import Cell, Cube
from bt_manip.control import ComputedTorque, Hold, Reference
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, RobotDescription, panda
from bt_manip.spatial import pose

TWO_LINKS = """
<mujoco model="two_links">
  <compiler angle="radian"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.3" armature="0.05" frictionloss="0.2"/>
      <geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0" mass="2"/>
      <body name="lower" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0" damping="0.1" armature="0.02" frictionloss="0.1"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="1"/>
        <site name="tip" pos="0.3 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="m1" joint="shoulder" ctrlrange="-40 40"/>
    <motor name="m2" joint="elbow" ctrlrange="-15 15"/>
  </actuator>
</mujoco>"""


class Wave(Reference):
    """A sinus in every joint, after a delay."""

    def __init__(self, q0, amplitude, rate, delay=0.0):
        self.q0, self.amplitude, self.rate, self.t = np.array(q0), amplitude, rate, 0.0
        self.delay = delay
        self.advance(0.0)

    def advance(self, dt):
        self.t += dt
        A, w = self.amplitude * (self.t > self.delay), self.rate
        t = self.t - self.delay
        # It starts at rest at q0: 1 - cos.
        self.q = self.q0 + A * (1 - np.cos(w * t))
        self.v = np.full_like(self.q0, A * w * np.sin(w * t))
        self.a = np.full_like(self.q0, A * w * w * np.cos(w * t))


class Post(composer.Entity):
    """A fixed block to put something on."""

    def _build(self, half_width=0.03):
        self.root = mjcf.RootElement(model="post")
        self.root.worldbody.add(
            "geom", type="box", size=(half_width, half_width, 0.05), pos=(0, 0, -0.05),
            solref=(0.004, 1),
        )  # fmt: skip

    @property
    def mjcf_model(self):
        return self.root


@pytest.fixture
def description(tmp_path):
    path = tmp_path / "two_links.xml"
    path.write_text(TWO_LINKS)
    return RobotDescription(
        name="two_links", model=str(path), arm_joints=("shoulder", "elbow"), tool_frame="tip",
        home=(0.3, -0.5), velocity=(3.0, 3.0), acceleration=(20.0, 20.0), jerk=(1000.0, 1000.0),
    )  # fmt: skip


@pytest.fixture
def make_arm(description):
    """Build a cell with the two links under a controller."""

    def make(controller, **gains):
        robot = Robot(description)
        control = controller(robot, **gains)
        robot.attach(control)
        cell = Cell()
        cell.add(robot)
        return cell, robot, control

    return make


def panda_cell(offset=0.0, cube=True, make_gripper=TwoFingerGripper):
    """Build a cell where the Panda's open fingers surround a cube on a post."""
    robot = Robot(panda(), gripper=make_gripper)
    control, gripper = ComputedTorque(robot), robot.gripper
    robot.attach(control)
    cell = Cell()
    cell.add(robot)
    control.reference = Hold(robot.q)
    if cube:
        mujoco.mj_forward(cell.model, cell.data)
        x, y, z = robot.tool_pose.translation
        rotation = robot.tool_pose.rotation
        shift = rotation[:, 1] * offset  # the fingers close along the tool's y axis
        yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
        turn = (np.cos(yaw / 2), 0, 0, np.sin(yaw / 2))
        with cell.editing():
            cell.add(Post(), pose((x, y, z - 0.040)))
            cell.add(Cube(), pose((x + shift[0], y + shift[1], z - 0.015), turn))
    return cell, robot, control, gripper


def step_until(cell, condition, limit=1.0):
    """Step until a condition holds; give the time it took."""
    start = cell.time
    while not condition():
        assert cell.time - start < limit, "it did not happen in time"
        cell.step()
    return cell.time - start
