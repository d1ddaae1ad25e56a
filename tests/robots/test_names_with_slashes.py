"""Models whose names contain `/`, as those of two arms in one file often do."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.cell import BodyNames, Cell, literal_name
from bt_manip.exceptions import MotionError
from bt_manip.grippers import TwoFingerGripper, two_finger_gripper
from bt_manip.kinematics import IKProblem, InverseKinematics, PositionTarget
from bt_manip.robots import Robot, RobotDescription, RobotError, compile_alone
from bt_manip_contracts import verify
from bt_manip_setup.finger_travel import measured

ARM = """
<mujoco>
  <compiler angle="radian"/>
  <default>
    <default class="arm"><joint range="-3 3" armature="0.05" damping="0.3"/></default>
    <default class="finger">
      <joint type="slide" range="0 0.04" armature="0.05" damping="5"/>
      <geom type="box" size="0.01 0.005 0.02" pos="0 0 0.02" mass="0.05"/>
    </default>
  </default>
  <asset>
    <mesh name="block" vertex=".05 .05 0 .05 -.05 0 -.05 .05 0 -.05 -.05 0 0 0 .1"/>
    <material name="grey" rgba="0.5 0.5 0.5 1"/>
  </asset>
  <worldbody>
    <body name="base">
      <geom type="mesh" mesh="block" material="grey"/>
      <body name="link_1" pos="0 0 0.1" childclass="arm">
        <joint name="turn" axis="0 0 1"/>
        <geom type="cylinder" size="0.03 0.05" mass="1"/>
        <body name="link_2" pos="0 0 0.08">
          <joint name="lift" axis="0 1 0"/>
          <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="1"/>
          <body name="hand" pos="0.35 0 0">
            <joint name="wrist" axis="0 1 0"/>
            <geom type="box" size="0.02 0.05 0.02" mass="0.3"/>
            <site name="tool" pos="0 0 0.07"/>
            <body name="finger_1" pos="0 0.006 0.04" childclass="finger">
              <joint name="slide_1" axis="0 1 0"/><geom name="pad_1"/>
            </body>
            <body name="finger_2" pos="0 -0.006 0.04" childclass="finger">
              <joint name="slide_2" axis="0 -1 0"/><geom name="pad_2"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <contact><exclude name="foot" body1="base" body2="link_1"/></contact>
  <tendon>
    <fixed name="both">
      <joint joint="slide_1" coef="0.5"/><joint joint="slide_2" coef="0.5"/>
    </fixed>
  </tendon>
  <equality><joint name="mirror" joint1="slide_1" joint2="slide_2"/></equality>
  <actuator>
    <motor name="turn_motor" joint="turn" ctrlrange="-30 30"/>
    <motor name="lift_motor" joint="lift" ctrlrange="-30 30"/>
    <motor name="wrist_motor" joint="wrist" ctrlrange="-30 30"/>
    <motor name="grip" tendon="both" ctrlrange="-50 50"/>
  </actuator>
</mujoco>
"""
JOINTS = ("turn", "lift", "wrist")


def two_arms() -> str:
    """Return the MJCF of two arms, whose names begin with their side."""
    both = mujoco.MjSpec()
    both.modelname = "duo"
    for side, y in (("left", 0.4), ("right", -0.4)):
        frame = both.worldbody.add_frame(pos=(0.0, y, 0.0))
        both.attach(mujoco.MjSpec.from_string(ARM), frame=frame, prefix=f"{side}/")
    both.compile()
    return both.to_xml()


@pytest.fixture(scope="module")
def description(tmp_path_factory) -> RobotDescription:
    path = tmp_path_factory.mktemp("duo") / "duo.xml"
    path.write_text(two_arms())
    described = RobotDescription(
        name="duo",
        model=str(path),
        arm_joints=tuple(f"left/{joint}" for joint in JOINTS),
        tool_frame="left/tool",
        home=(0.0, -0.5, 2.0),
        velocity=(2.0,) * 3,
        acceleration=(5.0,) * 3,
        jerk=(200.0,) * 3,
        exclude=(("left/base", "left/link_2"),),
        gripper=two_finger_gripper(
            joints=("left/slide_1", "left/slide_2"),
            fingers=("left/finger_1", "left/finger_2"),
            motor="left/both",
            open_width=0.08,
            max_speed=0.1,
            max_force=40.0,
        ),
    )
    return measured(described)


def test_the_compiled_robot_is_one_arm_of_the_file(description, rng):
    robot = Robot(description, gripper=TwoFingerGripper)
    compile_alone(robot)
    model = robot.make_model()
    assert verify(robot.mj_model, model.model, rng=rng, qpos=model.locked_qpos).worst < 1e-9
    original = mujoco.MjModel.from_xml_path(description.model)
    assert robot.mj_model.nexclude == original.nexclude + 1
    assert robot.mj_model.body_mass.sum() == pytest.approx(original.body_mass.sum())
    assert robot.limits.effort == pytest.approx(30.0)
    for model in (robot.mj_model, robot.alone):  # the other arm is locked
        names = [literal_name(model.joint(joint).name) for joint in range(model.njnt)]
        assert names == [f"left/{name}" for name in (*JOINTS, "slide_1", "slide_2")]
        assert model.body_weldid[model.body("right\\hand").id] == 0
        assert (model.neq, model.ntendon) == (1, 1)
    assert robot.mj_model.nu == 4


@pytest.mark.parametrize(
    ("key", "names", "message"),
    [
        ("arm_joints", ("left/turn", "left/lift", "left/wrst"), "joint 'left/wrst'.* 'left/wrist'"),
        ("tool_frame", "left/tol", "no site or body 'left/tol'; did you mean 'left/tool'"),
        ("exclude", (("left/base", "left/had"),), "no body 'left/had'; did you mean 'left/hand'"),
    ],
)
def test_messages_show_the_names_of_the_file(description, key, names, message):
    with pytest.raises(RobotError, match=message) as error:
        Robot(replace(description, **{key: names}), gripper=TwoFingerGripper)
    assert "\\" not in str(error.value)


def test_the_base_of_such_a_model_can_be_moved(description):
    robot = Robot(replace(description, T_rb=spatial.pose((0.0, -0.4, 0.2))))
    compile_alone(robot)
    assert np.allclose(robot.mj_model.body("left\\base").pos, (0.0, 0.0, 0.2))


def test_it_is_a_gripper_of_its_own_too(description):
    arm = replace(description, gripper=None, tool_frame="right/tool")
    hand = replace(description.gripper, model=description.model, mount="left/hand")
    robot = Robot(measured(replace(arm, gripper=hand)), gripper=TwoFingerGripper)
    compile_alone(robot)
    assert robot.mj_model.njnt == 5 + 10


def test_inverse_kinematics_takes_the_names_of_the_file(description):
    cell, robot = Cell(), Robot(description, gripper=TwoFingerGripper)
    cell.add(robot, free=False)
    ik, q0 = InverseKinematics(robot.make_model()), np.array(description.home)
    for name in ("left/hand", "duo/left/hand"):
        target = PositionTarget(name, (0.3, 0.5, 0.3))
        assert (
            ik.solve(IKProblem(targets=[target], joints=["left/turn", "left/lift"]), q0).q[2]
            == q0[2]
        )
    with pytest.raises(MotionError, match=re.escape("did you mean 'duo/left/hand'")):
        ik.solve(IKProblem(targets=[PositionTarget("duo/left/had", (0.3, 0.5, 0.3))]), q0)


def test_contacts_and_collisions_name_bodies_as_in_the_file(description, parts):
    station = build_station(parts, robot=description)
    station.gripper.move(0.04)
    station.step_until(lambda: not station.gripper.moving, timeout=3.0)
    assert station.gripper.width == pytest.approx(0.04, abs=1e-3)
    names = set(BodyNames(station.cell.model).of_body)
    assert {"duo/left/hand", "duo/right/hand"} <= names
    folded = station.arm.world.collisions(np.array([0.0, 1.4, 0.0]))
    assert any(pair.first.startswith("duo/left/") for pair in folded)
    assert not any("\\" in name for name in names)
