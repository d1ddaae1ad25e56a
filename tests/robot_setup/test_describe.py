"""Descriptions that are written from models."""

from pathlib import Path

import numpy as np
import pytest

from bt_manip.collision import CollisionWorld, self_collisions
from bt_manip.models import bundled_path
from bt_manip.robot_setup import Draft, check_description, describe_robot, description_text
from bt_manip.robots import RobotError, Tolerance, read_description

PANDA = str(bundled_path("panda/panda.xml"))
SIX_JOINTS = Path(__file__).parents[1] / "grippers" / "models" / "six_joints.urdf"
FIVE_JOINTS = Path(__file__).parents[1] / "robots" / "models" / "five_joints.xml"
TWO_LINK = Path(__file__).parents[1] / "robots" / "models" / "two_link.urdf"


@pytest.fixture(scope="module")
def draft(parts) -> Draft:
    return describe_robot(PANDA, parts, name="one")


def test_arm_gripper_and_tool_are_found(draft):
    found = draft.description
    assert found.arm_joints == tuple(f"joint{i}" for i in range(1, 8))
    assert found.gripper.parameters["fingers"] == ["left_finger", "right_finger"]
    assert found.gripper.parameters["open_width"] == pytest.approx(0.08, abs=2e-4)
    position = draft.robot.mj_data.site("tool").xpos  # of the model's own tool frame
    assert draft.robot.tool_pose.translation == pytest.approx(position, abs=0.01)


def test_efforts_of_the_model_are_not_repeated(draft):
    assert draft.description.effort is None
    assert draft.robot.limits.effort[0] == 87.0


def test_at_home_the_tool_points_down_and_the_arm_is_clear_of_itself(draft):
    robot = draft.robot
    assert robot.tool_pose.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-3)
    world = CollisionWorld(robot, robot.make_model())
    assert self_collisions(world, np.array(draft.description.home)) == []


def test_the_written_file_is_read_as_the_same_description(draft, tmp_path):
    path = tmp_path / "one.toml"
    path.write_text(description_text(draft.description, draft.notes, tmp_path, "an arm"))
    again, first = read_description(path), draft.description
    assert path.read_text().startswith("# an arm\n")
    assert "# CHOSEN" in path.read_text()
    for key in ("arm_joints", "home", "velocity", "jerk", "effort", "pedestal", "tool_limits"):
        assert getattr(again, key) == getattr(first, key)
    assert Path(again.model).resolve() == Path(first.model).resolve()
    assert again.T_rb.isApprox(first.T_rb, 1e-5) and again.T_ft.isApprox(first.T_ft, 1e-5)
    assert again.gripper.parameters == {**first.gripper.parameters}
    assert again.gripper.max_force == first.gripper.max_force


def test_a_described_robot_has_no_findings(draft, parts, tmp_path):
    path = tmp_path / "one.toml"
    path.write_text(description_text(draft.description, draft.notes, tmp_path, "an arm"))
    assert check_description(path, parts).findings == []


def test_an_arm_that_cannot_point_its_tool_down_is_refused(parts):
    with pytest.raises(RobotError, match=r"tool pointing down: .* \(--tool-frame\)"):
        describe_robot(str(TWO_LINK), parts, name="two_link")


def test_a_second_gripper_is_refused(parts):
    with pytest.raises(RobotError, match="has a gripper of its own, with joint 'finger_joint1'"):
        describe_robot(PANDA, parts, name="one", gripper=PANDA)


def test_velocities_and_efforts_of_urdf_are_kept(parts):
    found = describe_robot(str(SIX_JOINTS), parts, name="six").description
    assert found.arm_joints == ("pan", "lift", "elbow", "roll", "pitch", "turn")
    assert found.velocity == (3.0,) * 6
    assert found.effort is None and found.gripper is None


def test_an_adhesion_actuator_is_a_suction_cup(parts, tmp_path):
    cup = """<mujoco><worldbody><body name="cup"><geom type="cylinder" size="0.015 0.02"
        pos="0 0 0.02"/><site name="lip" pos="0 0 0.04"/></body></worldbody>
        <actuator><adhesion body="cup" gain="40" ctrlrange="0 1"/></actuator></mujoco>"""
    (tmp_path / "cup.xml").write_text(cup)
    gripper = str(tmp_path / "cup.xml")
    found = describe_robot(str(SIX_JOINTS), parts, name="six", gripper=gripper).description
    assert (found.gripper.kind, found.tool_frame) == ("suction", "lip")
    (tmp_path / "cup.xml").write_text(cup.replace('<site name="lip" pos="0 0 0.04"/>', ""))
    with pytest.raises(RobotError, match=r"the suction cup 'cup' has 0 sites: .* \(--tool-frame\)"):
        describe_robot(str(SIX_JOINTS), parts, name="six", gripper=gripper)


def test_an_arm_of_five_joints_gets_a_tolerance_for_what_it_cannot_reach(parts, tmp_path):
    draft = describe_robot(str(FIVE_JOINTS), parts, name="five")
    path = tmp_path / "five.toml"
    path.write_text(description_text(draft.description, draft.notes, tmp_path, "five"))
    assert read_description(path).tolerance == Tolerance(position=1e-4, rotation=5e-3)
    assert describe_robot(PANDA, parts, name="one").description.tolerance == Tolerance()
