"""Descriptions that are written from models."""

import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import load_plugins
from bt_manip.collision import CollisionWorld, self_collisions
from bt_manip.models import bundled_path
from bt_manip.robots import RobotError, Tolerance, description_text, read_description
from bt_manip_setup import check_description, describe_robot, gripper_names
from bt_manip_setup.describe import Draft
from bt_manip_setup.known_grippers import find_gripper
from bt_manip_setup.placement import find_home
from bt_manip_setup.reach import RadialReach
from tests.support.models import ROBOTS
from tests.support.small_arm import write_small_arm

PANDA = str(bundled_path("panda/panda.xml"))
MODELS = Path(__file__).parent / "models"
SIX_JOINTS, FIVE_JOINTS = ROBOTS / "six_joints.urdf", MODELS / "five_joints.xml"
TWO_LINK = MODELS / "two_link.urdf"


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
    path.write_text(description_text(draft.description, draft.notes, path, "an arm"))
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
    path.write_text(description_text(draft.description, draft.notes, path, "an arm"))
    assert check_description(path, parts, cycles=0).findings == []


def test_an_arm_that_cannot_point_its_tool_down_is_refused(parts):
    with pytest.raises(RobotError, match=r"tool pointing down: .* \(--tool-frame\)"):
        describe_robot(str(TWO_LINK), parts, name="two_link")


def test_a_second_gripper_is_refused(parts):
    with pytest.raises(RobotError, match="has a gripper of its own, with joint 'finger_joint1'"):
        describe_robot(PANDA, parts, name="one", gripper=PANDA)


def test_a_gripper_that_is_no_registered_one_may_be_one_of_menagerie(parts):
    assert find_gripper("leap_hand", parts) == ("menagerie:leap_hand/right_hand", None)


def test_velocities_and_efforts_of_urdf_are_kept(parts):
    found = describe_robot(str(SIX_JOINTS), parts, name="six").description
    assert found.arm_joints == ("pan", "lift", "elbow", "roll", "pitch", "turn")
    assert found.velocity == (3.0,) * 6
    assert found.effort is None and found.gripper is None


def test_an_adhesion_actuator_is_a_suction_cup(tmp_path):
    parts = load_plugins().parts
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


def test_an_arm_of_five_joints_gets_a_tolerance_for_what_it_cannot_reach(draft, parts, tmp_path):
    assert draft.description.tolerance == Tolerance()  # of seven joints
    draft = describe_robot(str(FIVE_JOINTS), parts, name="five")
    path = tmp_path / "five.toml"
    path.write_text(description_text(draft.description, draft.notes, path, "five"))
    assert read_description(path).tolerance == Tolerance(position=1e-4, rotation=5e-3)


def test_joints_of_almost_no_inertia_get_an_armature_that_is_marked_as_chosen(parts, tmp_path):
    write_small_arm(tmp_path, armature=0.0)
    path = tmp_path / "new.toml"
    draft = describe_robot(str(tmp_path / "small.xml"), parts, name="new")
    path.write_text(description_text(draft.description, draft.notes, path, "small"))
    armature, effort = np.array(draft.description.armature), draft.robot.limits.effort
    assert (2e-4 * effort[3:] < armature[3:]).all() and (armature[3:] <= 1e-3 * effort[3:]).all()
    assert not armature[:3].any()
    assert "# CHOSEN" in path.read_text().split("armature = ")[0].splitlines()[-2]
    facts = check_description(path, parts, cycles=0).facts
    assert not [fact for fact in facts if "inertia" in fact]


@pytest.mark.parametrize("link", ["base", "shoulder"])
def test_a_foot_that_reaches_below_the_origin_of_the_base_is_lifted(parts, tmp_path, link):
    """The first link turns about the vertical only: it keeps its height, too."""
    write_small_arm(tmp_path)
    model = tmp_path / "small.xml"
    body = f'<body name="{link}"'
    head, _, rest = model.read_text().partition(body)
    line, _, rest = rest.partition("\n")
    low = -0.017 - (0.06 if link == "shoulder" else 0.0)
    skirt = f'<geom type="sphere" size="0.01" pos="0.04 0 {low + 0.01}"/>'
    model.write_text(f"{head}{body}{line}{skirt}\n{rest}")
    found = describe_robot(str(model), parts, name="one").description
    standing = 0.0 if found.pedestal is None else found.pedestal[2]
    assert found.T_rb.translation[2] - standing == pytest.approx(0.017, abs=1e-6)


def test_a_robot_that_collides_wherever_its_tool_points_down_is_refused_with_the_pairs():
    reach = RadialReach(np.zeros(2), 0.0, np.ones(1), np.ones(1), np.ones((1, 1)))
    downward = SimpleNamespace(
        configuration=lambda position, floor: None, blocking=lambda: [("base", "forearm")]
    )
    with pytest.raises(RobotError, match="these bodies collide: 'base' and 'forearm'; check"):
        find_home(downward, reach, pin.SE3.Identity())


def test_an_arm_may_be_given_a_suction_cup_that_is_built():
    parts = load_plugins().parts
    draft = describe_robot(str(SIX_JOINTS), parts, name="six", gripper="suction")
    assert draft.description.gripper.kind == "suction"
    assert draft.robot.gripper.max_force == pytest.approx(0.25 * np.pi * 0.03**2 * 6e4)
    assert draft.notes["gripper"].startswith("CHOSEN")


def test_a_registered_gripper_is_given_by_its_name(parts, tmp_path):
    """Its parameters are those of the registered robot, its mount is turned to point outwards."""
    folder = tmp_path / "pincers"
    shutil.copytree(FIVE_JOINTS.parent, folder)
    post = read_description(folder / "post.toml")
    known = replace(parts, robots=parts.robots.with_part("post", post))
    assert gripper_names(known) == sorted([*gripper_names(parts), "pincers"])
    found = describe_robot(str(SIX_JOINTS), known, name="six", gripper="pincers").description
    given, known = dict(found.gripper.parameters), dict(post.gripper.parameters)
    assert given.pop("travel")["open_width"] == pytest.approx(known.pop("travel")["open_width"])
    assert given == known
    assert found.tool_frame == post.tool_frame and found.gripper.mount == "mount"
    assert np.linalg.norm(found.gripper.T_mg.translation) == pytest.approx(0.01)


def test_an_unknown_gripper_is_refused_with_the_known_ones(parts):
    with pytest.raises(
        RobotError, match=r"no gripper or model 'suctoin'; did you mean 'suction'\? \(--g"
    ):
        describe_robot(str(SIX_JOINTS), parts, name="six", gripper="suctoin")


def test_a_position_is_reached_where_the_gripper_stays_above_the_table():
    reach = RadialReach(
        np.zeros(2), 0.0, np.arange(3.0), np.arange(-1.0, 2.0), np.zeros((3, 3)), below_tool=0.3
    )
    assert reach.reached(0.0).all(axis=1).tolist() == [False, False, True]
    height = np.array([0.2, 0.4])
    assert reach.covers(np.full(2, 0.5), height, 0.0).tolist() == [False, True]


@pytest.mark.parametrize("friction, kept", [(2.0, True), (40.0, False)])  # [N] of each finger
def test_dry_friction_that_takes_the_grip_is_left_out(parts, tmp_path, friction, kept):
    path = write_small_arm(tmp_path).with_name("small.xml")
    text, old = path.read_text(), 'damping="10" frictionloss="0"'
    assert old in text
    path.write_text(text.replace(old, f'damping="10" frictionloss="{friction}"'))
    draft = describe_robot(str(path), parts, name="small")
    assert draft.description.gripper.parameters.get("frictionloss") == (None if kept else 0.0)
    model = draft.robot.mj_model
    fingers = [model.joint(name).dofadr[0] for name in ("left", "right")]
    assert model.dof_frictionloss[fingers] == pytest.approx(friction if kept else 0.0)
