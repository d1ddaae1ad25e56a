from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.robots import Robot, RobotError
from tests.robot_fixtures import compiled, described

TWO_LINK = Path(__file__).parent / "models" / "two_link.urdf"


def test_a_robot_may_be_urdf():
    robot = compiled(described(TWO_LINK))
    assert robot.limits.effort.tolist() == [60.0, 30.0]
    assert robot.limits.upper.tolist() == [2.0, 2.5]
    tool = robot.make_model().pose(np.zeros(2)).translation
    assert tool == pytest.approx([0.0, 0.0, 0.85])


def test_urdf_with_a_missing_mesh_names_file_and_line(tmp_path):
    path = tmp_path / "broken.urdf"
    box = '<cylinder radius="0.03" length="0.3"/>'
    path.write_text(TWO_LINK.read_text().replace(box, '<mesh filename="no.stl"/>'))
    with pytest.raises(RobotError, match=r"broken.urdf:\d+: there is no mesh 'no.stl'"):
        Robot(described(path))


MOBILE = """
<mujoco model="mobile">
  <compiler angle="radian" fusestatic="true"/>
  <option><flag contact="disable"/></option>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1"/>
    <body name="base_link" pos="0 0 0.1">
      <freejoint name="root"/>
      <geom type="box" size="0.2 0.2 0.1"/>
      <body name="mast">
        <joint name="lift" axis="0 0 1" range="-1 1"/>
        <geom size="0.02" fromto="0 0 0 0 0 0.5" type="capsule"/>
        <body name="one" pos="0 0 0.5">
          <joint name="shoulder" axis="0 0 1" range="-2 2"/>
          <geom size="0.02" fromto="0 0 0 0 0 0.3" type="capsule"/>
          <body name="lamp"><joint name="tilt" axis="0 1 0"/><geom size="0.02"/></body>
          <body name="two" pos="0 0 0.3">
            <joint name="elbow" axis="0 1 0" range="-2 2"/>
            <geom size="0.02" fromto="0 0 0 0 0 0.3" type="capsule"/>
            <body name="strut"><joint name="slave" axis="0 1 0"/><geom size="0.02"/></body>
            <body name="plate" pos="0 0 0.3"><site name="tip"/><geom size="0.01"/></body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="slave" joint2="elbow"/></equality>
</mujoco>
"""


def test_of_a_larger_robot_only_the_joints_of_the_arm_move_and_its_world_is_left_out(tmp_path):
    path = tmp_path / "mobile.xml"
    path.write_text(MOBILE)
    lifted = spatial.pose((0.0, 0.0, 0.2))
    robot = compiled(replace(described(path), effort=(9.0, 9.0), T_rb=lifted))
    model = robot.mj_model
    assert [model.joint(j).name for j in range(model.njnt)] == ["shoulder", "elbow", "slave"]
    assert model.body("base_link").pos[2] == pytest.approx(0.3)  # fused with nothing
    assert model.geom_bodyid.min() > 0 and model.opt.disableflags == 0
