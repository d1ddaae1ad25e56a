"""Descriptions that are written from models."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import trimesh

from bt_manip import load_plugins
from bt_manip.collision import CollisionWorld, self_collisions
from bt_manip.grippers import collision_geoms_of
from bt_manip.models import bundled_path
from bt_manip.robots import (
    FoundGripper,
    Payload,
    Robot,
    RobotError,
    Tolerance,
    ToolLimits,
    read_description,
)
from bt_manip_setup import (
    check_description,
    describe_robot,
    description_text,
    gripper_keys,
    gripper_names,
    make_robot,
    placement,
)
from bt_manip_setup.describe import Draft
from bt_manip_setup.gripper_keys import standing_pose
from bt_manip_setup.joint_data import estimate_efforts, joint_data, light_joints
from bt_manip_setup.known_grippers import find_gripper
from bt_manip_setup.placement import find_home
from bt_manip_setup.reach import RadialReach
from tests.support.small_arm import write_small_arm

from .assembled_arms import SIX_JOINTS, box, limit, part, write_arm

PANDA = str(bundled_path("panda/panda.xml"))
MODELS = Path(__file__).parent / "models"
FIVE_JOINTS = MODELS / "five_joints.xml"
TWO_LINK = MODELS / "two_link.urdf"


@pytest.fixture(scope="module")
def draft(parts) -> Draft:
    return describe_robot(PANDA, parts, name="one")


def test_arm_gripper_and_tool_are_found(draft):
    found = draft.description
    assert found.arm_joints == tuple(f"joint{i}" for i in range(1, 8))
    assert found.gripper.parameters["joints"] == ["finger_joint1", "finger_joint2"]
    assert found.gripper.parameters["fingers"] == ["left_finger", "right_finger"]
    assert found.gripper.parameters["open_width"] == 0.08
    assert found.tool_frame == "hand" and found.T_ft.rotation == pytest.approx(np.eye(3))
    assert found.gripper.parameters["max_speed"] == 0.1
    stiff = {"solref": [0.004, 1.0], "solimp": [0.95, 0.99, 0.001]}
    assert found.gripper.parameters["pads"] == stiff
    position = draft.robot.mj_data.site("tool").xpos  # of the model's own tool frame
    assert draft.robot.tool_pose.translation == pytest.approx(position, abs=1e-3)
    assert found.tolerance == Tolerance()  # of seven joints
    assert found.tool_limits == ToolLimits(velocity=1.0, acceleration=5.0, jerk=500.0)
    assert found.effort is None  # it is that of the model
    assert draft.robot.limits.effort[0] == 87.0


def test_at_home_the_tool_points_down_and_the_arm_is_clear_of_itself(draft):
    robot = draft.robot
    assert robot.tool_pose.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-3)
    world = CollisionWorld(robot, robot.make_model())
    assert self_collisions(world, np.array(draft.description.home)) == []
    limits = robot.limits
    share = (np.array(draft.description.home) - limits.lower) / (limits.upper - limits.lower)
    assert share.min() > 0.1 and share.max() < 0.9  # also of the elbow, which cannot be straight


def test_an_arm_that_reaches_only_below_its_base_stands_on_a_square_block(draft):
    heights = np.linspace(-1, 1, 41)
    low = np.where(heights < -0.04, 5.0, -np.inf)[:, np.newaxis] + np.zeros(20)
    reach = RadialReach(np.zeros(2), 0.0, np.linspace(0, 2, 20), heights, low)
    found = placement.place_base(draft.robot, reach)
    assert found.pedestal is not None
    x, y, height = found.pedestal
    assert x == y == pytest.approx(2.0 * placement.measure_foot(draft.robot)[1])
    assert height > 0.0


def test_an_arm_without_a_foot_stands_on_its_origin(draft, monkeypatch):
    none = np.zeros(draft.robot.mj_model.nbody, dtype=bool)
    monkeypatch.setattr(placement, "foot_bodies", lambda robot: none)
    assert placement.measure_foot(draft.robot) == (0.0, placement.FOOT[0])


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


def test_velocity_and_effort_limits_are_those_of_a_urdf_if_it_has_all(tmp_path):
    model = mujoco.MjModel.from_xml_path(str(TWO_LINK))
    limits = joint_data(model, (0, 1), TWO_LINK)
    assert limits.velocity == (1.2, 0.8) and limits.velocity_known
    assert limits.effort == pytest.approx((60.0, 30.0))
    text = TWO_LINK.read_text()
    assert ' velocity="0.8"' in text
    (tmp_path / "arm.urdf").write_text(text.replace(' velocity="0.8"', ""))
    limits = joint_data(model, (0, 1), tmp_path / "arm.urdf")
    assert limits.velocity == (1.5, 1.5) and not limits.velocity_known


def test_limits_that_a_model_lacks_are_those_of_the_page_on_descriptions(tmp_path):
    links = '<joint type="slide"/><geom size="0.1"/><body><joint/><geom size="0.1"/></body>'
    xml = f"<mujoco><worldbody><body>{links}</body></worldbody></mujoco>"
    (tmp_path / "arm.xml").write_text(xml)
    found = joint_data(mujoco.MjModel.from_xml_string(xml), (0, 1), tmp_path / "arm.xml")
    assert found == ((0.5, 1.5), (2.0, 5.0), (100.0, 250.0), (None, None), False)


def test_estimated_efforts_hold_and_accelerate_the_arm_with_a_tenth_of_its_mass(draft):
    model, rng = draft.robot.make_model(), np.random.default_rng(1)
    found, limits = np.array(estimate_efforts(model)), model.limits
    loaded = model.with_payload(Payload(0.1 * pin.computeTotalMass(model.model)))
    efforts = []
    for q in rng.uniform(*limits.sampling_bounds(), (300, 7)):
        signs = rng.choice((-1.0, 1.0), (2, 7))
        v, a = signs * (limits.velocity, limits.acceleration)
        efforts.append(loaded.effort(q, v, a))
    largest = np.abs(efforts).max(axis=0)
    assert (found / (1.5 * largest))[:6].mean() == pytest.approx(1.0, abs=0.1)
    assert found[6] == pytest.approx(0.05 * found.max(), rel=0.1)  # more than it needs
    assert found[6] > 2.0 * largest[6]


def test_a_joint_is_light_below_1e_4_kg_m2_for_each_newton_metre_of_its_limit(draft):
    robot, model = draft.robot, draft.robot.make_model()
    mujoco.mj_forward(robot.mj_model, robot.mj_data)
    M = np.zeros((robot.mj_model.nv, robot.mj_model.nv))
    mujoco.mj_fullM(robot.mj_model, robot.mj_data, M)
    inertia = 1.0 / np.diag(np.linalg.inv(M[np.ix_(robot.dof_adr, robot.dof_adr)]))
    effort = 1e4 * inertia * (0.98, 1.02, 0.98, 1.02, 1.02, 0.98, 1.02)
    arm = SimpleNamespace(
        model=model.model, data=model.data, home=model.home, limits=SimpleNamespace(effort=effort)
    )
    assert light_joints(arm).tolist() == (effort > 1e4 * inertia).tolist()


@pytest.mark.parametrize(
    ("model", "gripper", "message"),
    [
        (TWO_LINK, None, r"tool pointing down: .* \(--tool-frame\)"),
        (PANDA, PANDA, "has a gripper of its own, with joint 'finger_joint1'"),
        (SIX_JOINTS, "suctoin", r"no gripper or model 'suctoin'; did you mean 'suction'\? \(--g"),
    ],
)
def test_what_cannot_be_described_is_refused(parts, model, gripper, message):
    with pytest.raises(RobotError, match=message):
        describe_robot(str(model), parts, name="one", gripper=gripper)


def test_a_gripper_that_is_no_registered_one_may_be_one_of_menagerie(parts):
    assert find_gripper("leap_hand", parts) == ("menagerie:leap_hand/right_hand", None)


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


def test_an_arm_of_five_joints_gets_a_tolerance_and_invented_masses_are_marked(parts, tmp_path):
    model, path = tmp_path / "arm.xml", tmp_path / "five.toml"
    model.write_text(FIVE_JOINTS.read_text().replace('density="1500" ', ""))
    draft = describe_robot(str(model), parts, name="five")
    path.write_text(description_text(draft.description, draft.notes, path, "five"))
    assert read_description(path).tolerance == Tolerance(position=1e-4, rotation=5e-3)
    assert draft.notes["model"].startswith("CHOSEN") and "kg" in draft.notes["model"]


def test_joints_of_almost_no_inertia_are_named_and_get_an_armature_that_is_marked_as_chosen(
    parts, tmp_path, monkeypatch
):
    monkeypatch.setattr("bt_manip_setup.check.ROBOT_CONTRACT", ())
    path, light = tmp_path / "new.toml", write_small_arm(tmp_path, armature=0.0)
    light.write_text(f"armature = 0.0\n{light.read_text()}")
    draft = describe_robot(str(light.with_name("small.xml")), parts, name="new")
    path.write_text(description_text(draft.description, draft.notes, path, "small"))
    armature, effort = np.array(draft.description.armature), draft.robot.limits.effort
    needed = np.array(estimate_efforts(draft.robot.make_model()))
    expected = 1e-3 * np.minimum(effort, 10.0 * needed)  # 1e-3 kg m2 for each N m
    assert armature[3:] == pytest.approx(expected[3:], rel=0.1)
    assert not armature[:3].any()
    assert "# CHOSEN" in path.read_text().split("armature = ")[0].splitlines()[-2]
    found, none = (
        [fact for fact in check_description(file, parts, cycles=0).facts if "inertia" in fact]
        for file in (light, path)
    )
    assert "almost no inertia: joint4, joint5, joint6; give 'armature'" in found[0] and not none


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
    found = draft.description
    assert found.arm_joints == ("pan", "lift", "elbow", "roll", "pitch", "turn")
    assert found.velocity == (3.0,) * 6 and found.effort is None  # they are those of URDF
    assert found.gripper.kind == "suction"
    assert found.T_ft.translation == pytest.approx((0.0, 0.0, 0.05))
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


@pytest.mark.parametrize("height, lift", [(0.03, 0.0), (-0.03, 0.05)])  # [m]
def test_a_gripper_stands_on_its_mount_with_its_origin_or_with_what_is_lower(height, lift):
    base = f'<body name="palm"><geom type="box" size="0.02 0.02 0.02" pos="0 0 {height}"/></body>'
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="link"><joint name="turn"/><geom size="0.01"/>'
        f"{base}</body></worldbody></mujoco>"
    )
    arm = SimpleNamespace(arm_joints=["turn"], tool_frame="link")
    T = standing_pose(model, arm, FoundGripper({}, None, "palm", pin.SE3.Identity()))
    assert T.isApprox(pin.SE3(np.eye(3), np.array([0.0, 0.0, lift])))


def split_connected(mesh: trimesh.Trimesh, **options: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Decompose a mesh of separate convex shapes, as coacd does."""
    return [(piece.vertices, piece.faces) for piece in mesh.split()]


def test_a_jaw_inside_the_hull_of_a_palm_collides_by_convex_parts_in_every_run(
    parts, tmp_path, monkeypatch
):
    """The palm has one fixed finger. Without coacd, the message names what decomposes it."""
    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path / "kept"))
    monkeypatch.setitem(sys.modules, "coacd", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    monkeypatch.setattr(gripper_keys, "find_spec", lambda name: None)
    shapes = {(0, 0.02, -0.05): (0.03, 0.1, 0.02), (0, -0.03, 0.01): (0.02, 0.01, 0.1)}
    boxes = [trimesh.creation.box(size).apply_translation(at) for at, size in shapes.items()]
    trimesh.util.concatenate(boxes).export(tmp_path / "palm.stl")
    palm = '<collision><geometry><mesh filename="palm.stl"/></geometry></collision>'
    plate = box("0.02 0.01 0.06")
    arm = write_arm(tmp_path / "arm.urdf", [
        part("palm", palm, "fixed", "0 0 0.09"),
        part("jaw", plate, "revolute", "0 0.005 -0.04", "1 0 0", limit(-0.4, 0.4), "palm"),
    ])  # fmt: skip
    message = "'palm' and 'jaw' overlap at every opening: .* pip install 'bt-manip.convex.'"
    with pytest.raises(RobotError, match=message):
        describe_robot(str(arm), parts, name="arm")
    coacd = SimpleNamespace(
        set_log_level=lambda level: None, Mesh=trimesh.Trimesh, run_coacd=split_connected
    )
    monkeypatch.setattr("importlib.util.find_spec", lambda name: name)
    monkeypatch.setattr(gripper_keys, "find_spec", lambda name: name)
    monkeypatch.setitem(sys.modules, "coacd", coacd)
    draft, path = describe_robot(str(arm), parts, name="arm"), tmp_path / "arm.toml"
    path.write_text(description_text(draft.description, draft.notes, path, "an arm"))
    again = read_description(path)
    assert again.convex_parts == ("palm",)
    assert set(again.gripper.parameters["fingers"]) == {"palm", "jaw"}
    models = [robot.mj_model for robot in (draft.robot, make_robot(again, parts))]
    assert [len(collision_geoms_of(m, m.body("palm").id)) for m in models] == [2, 2]
    undivided = Robot(replace(again, convex_parts=(), gripper=None)).alone
    assert models[1].body("palm").mass == pytest.approx(undivided.body("palm").mass)
    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path / "other"))
    monkeypatch.setitem(sys.modules, "coacd", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(RobotError, match="key 'convex_parts': 'palm': .* pip install"):
        make_robot(again, parts)
