"""Models whose names contain `/`, as those of two arms in one file often do."""

import re
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.cell import BodyNames, Cell, literal_name
from bt_manip.exceptions import MotionError
from bt_manip.grippers import TwoFingerGripper, two_finger_gripper
from bt_manip.kinematics import IKProblem, InverseKinematics, PositionTarget
from bt_manip.robots import Robot, RobotDescription, RobotError, read_description
from bt_manip_contracts import verify
from bt_manip_setup.finger_travel import measured
from tests.robot_fixtures import compiled

FILE = Path(__file__).parent / "models" / "five_joints.toml"
MORE = """
  <asset>
    <mesh name="block" vertex=".05 .05 0 .05 -.05 0 -.05 .05 0 -.05 -.05 0 0 0 .1"/>
    <material name="grey" rgba="0.5 0.5 0.5 1"/>
  </asset>
  <worldbody><body name="stand"><geom type="mesh" mesh="block" material="grey"/></body></worldbody>
  <contact><exclude name="bend" body1="foot" body2="upper_arm"/></contact>
  <tendon>
    <fixed name="both">
      <joint joint="left_slide" coef="0.5"/><joint joint="right_slide" coef="0.5"/>
    </fixed>
  </tendon>
  <equality><joint name="mirror" joint1="left_slide" joint2="right_slide"/></equality>
  <actuator><motor name="grip" tendon="both" ctrlrange="-80 80"/></actuator>
</mujoco>"""


def two_arms() -> str:
    """Return the MJCF of two arms, whose names begin with their side."""
    both = mujoco.MjSpec()
    arm = FILE.with_suffix(".xml").read_text().replace("</mujoco>", MORE)
    for side, y in (("left", 0.4), ("right", -0.4)):
        frame = both.worldbody.add_frame(pos=(0.0, y, 0.0))
        both.attach(mujoco.MjSpec.from_string(arm), frame=frame, prefix=f"{side}/")
    both.compile()
    return both.to_xml()


@pytest.fixture(scope="module")
def description(tmp_path_factory) -> RobotDescription:
    path = tmp_path_factory.mktemp("duo") / "duo.xml"
    path.write_text(two_arms())
    arm = read_description(FILE)
    described = replace(
        arm,
        name="duo",
        model=str(path),
        arm_joints=tuple(f"left/{joint}" for joint in arm.arm_joints),
        tool_frame="left/tool",
        exclude=(("left/foot", "left/turret"),),
        gripper=two_finger_gripper(
            joints=("left/left_slide", "left/right_slide"),
            fingers=("left/left_finger", "left/right_finger"),
            motor="left/both",
            open_width=0.08,
            max_speed=0.1,
            max_force=40.0,
        ),
    )
    return measured(described)


def test_the_compiled_robot_is_one_arm_of_the_file(description, rng):
    robot = compiled(description, gripper=TwoFingerGripper)
    model = robot.make_model()
    assert verify(robot.mj_model, model.model, rng=rng, qpos=model.locked_qpos).worst < 1e-9
    original = mujoco.MjModel.from_xml_path(description.model)
    assert robot.mj_model.nexclude == original.nexclude + 1
    assert robot.mj_model.body_mass.sum() == pytest.approx(original.body_mass.sum())
    assert robot.limits.effort.tolist() == [150.0] * 3 + [30.0] * 2
    for model in (robot.mj_model, robot.alone):  # the other arm is locked
        names = [literal_name(model.joint(joint).name) for joint in range(model.njnt)]
        fingers = ("left/left_slide", "left/right_slide")
        assert names == [*description.arm_joints, *fingers]
        assert model.body_weldid[model.body("right\\hand").id] == 0
        assert (model.neq, model.ntendon) == (1, 1)
    assert robot.mj_model.nu == 6


@pytest.mark.parametrize(
    ("key", "names", "message"),
    [
        ("arm_joints", ("left/elbw", *"abcd"), "no joint 'left/elbw'; did you mean 'left/elbow'"),
        ("tool_frame", "left/tol", "no site or body 'left/tol'; did you mean 'left/tool'"),
        ("exclude", (("left/foot", "left/had"),), "no body 'left/had'; did you mean 'left/hand'"),
    ],
)
def test_messages_show_the_names_of_the_file(description, key, names, message):
    with pytest.raises(RobotError, match=message) as error:
        Robot(replace(description, **{key: names}), gripper=TwoFingerGripper)
    assert "\\" not in str(error.value)


def test_the_base_of_such_a_model_can_be_moved(description):
    robot = compiled(replace(description, T_rb=spatial.pose((0.0, -0.4, 0.2))))
    assert np.allclose(robot.mj_model.body("left\\foot").pos, (0.0, 0.0, 0.2))


def test_it_is_a_gripper_of_its_own_too(description):
    arm = replace(description, gripper=None, tool_frame="right/tool")
    hand = replace(description.gripper, model=description.model, mount="left/hand")
    robot = compiled(measured(replace(arm, gripper=hand)), gripper=TwoFingerGripper)
    assert robot.mj_model.njnt == 7 + 14


def test_inverse_kinematics_takes_the_names_of_the_file(description):
    cell, robot = Cell(), Robot(description, gripper=TwoFingerGripper)
    cell.add(robot, free=False)
    ik, q0 = InverseKinematics(robot.make_model()), np.array(description.home)
    for name in ("left/hand", "duo/left/hand"):
        targets = [PositionTarget(name, (0.3, 0.5, 0.3))]
        problem = IKProblem(targets=targets, joints=["left/base", "left/shoulder", "left/elbow"])
        assert (ik.solve(problem, q0).q[3:] == q0[3:]).all()
    with pytest.raises(MotionError, match=re.escape("did you mean 'duo/left/hand'")):
        ik.solve(IKProblem(targets=[PositionTarget("duo/left/had", (0.3, 0.5, 0.3))]), q0)


def test_contacts_and_collisions_name_bodies_as_in_the_file(description, parts):
    station = build_station(parts, robot=description)
    station.gripper.move(0.04)
    station.step_until(lambda: not station.gripper.moving, timeout=3.0)
    assert station.gripper.width == pytest.approx(0.04, abs=1e-3)
    names = set(BodyNames(station.cell.model).of_body)
    assert {"duo/left/hand", "duo/right/hand"} <= names
    folded = station.arm.world.collisions(np.array([0.0, 2.5, 0.0, 0.0, 0.0]))
    assert any(pair.first.startswith("duo/left/") for pair in folded)
    assert not any("\\" in name for name in names)
