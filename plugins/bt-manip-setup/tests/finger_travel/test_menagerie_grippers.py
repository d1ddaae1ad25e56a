"""Grippers of MuJoCo Menagerie, found in their models, hold a cube of 40 mm."""

import os
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from bt_manip.grippers import TwoFingerGripper, two_finger_gripper
from bt_manip.kinematics import InverseKinematics
from bt_manip.robots import Robot, RobotDescription, compile_alone
from bt_manip.spatial import pointing_down
from bt_manip_setup.finger_travel import find_fingers, measured

from .scenes import Scene

FORCE = 10.0  # [N]
SEVEN = tuple(f"joint{i}" for i in range(1, 8))
SIX = ("waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate")
FIVE = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll")
ARMS = {
    "franka_emika_panda/panda.xml": (SEVEN, (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)),
    "ufactory_xarm7/xarm7.xml": (SEVEN, (0.0, -0.247, 0.0, 0.909, 0.0, 1.15644, 0.0)),
    "trossen_vx300s/vx300s.xml": (SIX, (0.0, -0.15, 0.46, 0.0, 1.26, 0.0)),
    "trossen_wx250s/wx250s.xml": (SIX, (0.0, 0.02, 0.16, 0.0, 1.39, 0.0)),
    "trs_so_arm100/so_arm100.xml": (FIVE, (0.0, -1.57, 1.57, 1.57, -1.57)),
}
USUAL = ("franka_emika_panda/panda.xml", "trs_so_arm100/so_arm100.xml")
# The model's dry friction of 1 N m in six small joints would take more than the gripper has.
CHANGES = {"ufactory_xarm7/xarm7.xml": {"armature": 0.005, "frictionloss": 0.0}}


@pytest.fixture(params=[i if i in USUAL else pytest.param(i, marks=pytest.mark.soak) for i in ARMS])
def robot(request):
    """Give an arm described by what is found in its model, its tool pointing straight down."""
    shared = Path(__file__).resolve().parents[5] / "shared"
    roots = [
        Path(os.environ.get("MENAGERIE_ROOT", shared / "menagerie")),
        Path(os.environ.get("MENAGERIE_MORE_ROOT", shared / "menagerie_more")),
    ]
    files = [root / request.param for root in roots if (root / request.param).is_file()]
    if not files:
        pytest.skip(f"no {request.param} in {' and '.join(map(str, roots))}")
    joints, home = ARMS[request.param]
    found = find_fingers(mujoco.MjModel.from_xml_path(str(files[0])), joints)
    n = len(joints)
    description = RobotDescription(
        name="arm", model=str(files[0]), arm_joints=joints, home=home,
        tool_frame=found.body, T_ft=found.T_bt,
        velocity=(2.0,) * n, acceleration=(5.0,) * n, jerk=(500.0,) * n, effort=(60.0,) * n,
        gripper=two_finger_gripper(
            joints=found.joints, fingers=found.fingers, max_speed=0.2, max_force=12.0,
            pads={"solref": (0.004, 1.0), "solimp": (0.95, 0.99, 0.001)},
            **CHANGES.get(request.param, {}),
        ),
    )  # fmt: skip
    if n > 5:
        rough = Robot(description)
        compile_alone(rough)
        T = rough.tool_pose
        x, y = T.rotation[:2, 0]
        down = pointing_down(T.translation, float(np.arctan2(y, x)))
        result = InverseKinematics(rough.make_model()).solve(down, rough.q)
        assert result.solved
        description = replace(description, home=tuple(result.q))
    return Robot(measured(description), gripper=TwoFingerGripper)


def test_it_opens_and_grips_and_holds_a_cube_or_says_that_there_is_none(robot):
    scene, gripper = Scene(robot), robot.gripper
    cell = scene.cell
    assert gripper.is_open
    gripper.close(FORCE)
    scene.until(lambda: gripper.closed_on_nothing)
    assert not gripper.held
    gripper.open()
    scene.until(lambda: gripper.is_open)
    scene.grasp(0.04)
    gripper.close(FORCE)
    assert scene.until(lambda: gripper.steady) < 6.0 * FORCE  # the impact, for a few milliseconds
    assert gripper.held == ("cube",)
    cell.remove("post")
    cell.step(300)
    before = robot.tool_pose.actInv(cell.pose("cube").translation)
    cell.step(500)
    after = robot.tool_pose.actInv(cell.pose("cube").translation)
    assert np.linalg.norm(after - before) < 5e-4
    assert gripper.steady and gripper.held == ("cube",)
    assert min(gripper.forces) == pytest.approx(FORCE, rel=0.05)
    gripper.open()
    scene.until(lambda: gripper.is_open and gripper.is_free)
