"""A suction cup holds what seals it, up to its pressure times its area, and notices the loss."""

import json
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station
from bt_manip.behaviours import (
    CloseGripper,
    Drop,
    Grasp,
    Hover,
    IsHolding,
    Lift,
    MoveToPose,
    OpenGripper,
    PlaceAt,
    Reach,
)
from bt_manip.bt import NodeStatus, Sequence
from bt_manip.cell import Cell
from bt_manip.cell.objects import Box, Capsule, ConvexMesh, Cylinder, Sphere
from bt_manip.robots import Robot, RobotError, read_description
from bt_manip.spatial import pointing_down, pose, quat_wxyz
from bt_manip.testing import Trial
from bt_manip_contracts import ROBOT_CONTRACT, RobotCase
from bt_manip_hands import SuctionGripper, suction_gripper
from bt_manip_hands.suction.lip import seals
from tests.support.held import check_held
from tests.support.models import ROBOTS
from tests.support.program import run_program

WITH_CUP = ROBOTS / "six_joints_cup.toml"
ON_UR5E = Path(__file__).with_name("ur5e_cup.toml")
TABLE = 1.015  # [m]


@pytest.fixture(scope="module")
def built(parts):
    station = build_station(parts, robot=str(WITH_CUP))
    return station, station.get_state()


@pytest.fixture
def station(built):
    station, start = built
    station.set_state(start)
    return station


def put(station, entity, x=0.4, y=0.1):
    station.cell.add(entity, pose((x, y, TABLE + entity.rest_height)), name="thing")
    station.cell.step(200)
    return station


def picked(station, entity, force=40.0):
    tree = Sequence(children=[
        Hover(object="thing"), Reach(object="thing"), Grasp(object="thing", force=force),
        Lift(height=0.2), IsHolding(object="thing"),
    ])  # fmt: skip
    status = put(station, entity).run(tree).status
    assert status is NodeStatus.SUCCESS, tree.tip().feedback_message
    return station


def on_top(height, x=0.4, y=0.1):
    """Return the pose of a cup that touches the top of an object that stands on the table."""
    return pointing_down((x, y, TABLE + height), 0.0)


def tug(station, force, duration):
    """Pull the object down for some time [N, s]."""
    model, data = station.cell.model, station.cell.data
    body = int(np.flatnonzero(model.body_rootid == station.cell.body_id("thing"))[-1])
    data.xfrc_applied[body, 2] = -force
    station.cell.step(round(1e3 * duration))
    data.xfrc_applied[body, 2] = 0.0


@pytest.mark.parametrize(
    "entity",
    [
        Box(), Sphere(), ConvexMesh(), Cylinder(radius=0.03), Capsule(radius=0.025),
    ],
    ids=lambda entity: entity.kind,
)  # fmt: skip
def test_flat_and_curved_objects_are_picked_and_dropped_with_the_same_behaviours(station, entity):
    picked(station, entity)
    drop = Drop(container="basket")
    assert station.run(drop).status is NodeStatus.SUCCESS, drop.feedback_message
    assert station.arm.payload is None and station.gripper.is_open


def test_it_pulls_with_the_asked_force_up_to_its_pressure_times_its_area(station):
    assert station.gripper.max_force == pytest.approx(60e3 * np.pi * 0.015**2)  # 42 N
    picked(station, Box(mass=2.0, size=(0.1, 0.1, 0.1)), force=42.0)
    assert station.gripper.forces[0] == pytest.approx(42.0 - 2.0 * 9.81, abs=0.5)
    pull = station.robot.mj_data.actuator_force[station.gripper.cup.ctrl]
    assert abs(pull) == pytest.approx(42.0)


def test_a_built_cup_is_as_wide_and_long_as_described_with_its_lip_at_the_tool(station):
    model, data, cup = station.cell.model, station.cell.data, station.gripper.cup
    T = station.robot.tool_pose
    lip = [g for g in cup.geoms if model.geom_type[g] == int(mujoco.mjtGeom.mjGEOM_SPHERE)]
    at = (data.geom_xpos[lip] - T.translation) @ T.rotation
    assert np.hypot(*at[:, :2].T) + model.geom_size[lip, 0] == pytest.approx(0.015)
    assert at[:, 2] + model.geom_size[lip, 0] == pytest.approx(0.0, abs=1e-9)
    angles = np.sort(np.arctan2(at[:, 1], at[:, 0]))
    assert np.diff(angles) == pytest.approx(2.0 * np.pi / len(lip))
    round_ = [g for g in cup.geoms if g not in lip]
    ends = np.array([T.actInv(data.geom_xpos[g])[2] for g in round_])
    radius, half, _ = model.geom_size[round_].T
    assert radius == pytest.approx((np.hypot(*at[0, :2]), 0.015, 0.0045))  # a thin stem
    skirt, bell, stem = zip(ends + half, ends - half, strict=True)
    # A ball reaches in by half a radius. There are no gaps down to the length of 6 cm.
    assert (*skirt, bell[0]) == pytest.approx((-0.0015, -0.0105, -0.0105))
    assert (bell[1], stem[1]) == pytest.approx((stem[0], -0.06))
    assert bell[0] - bell[1] == pytest.approx(0.015)  # half a diameter
    assert model.body_mass[model.geom_bodyid[lip[0]]] == pytest.approx(8 * 1e-3 + 0.015 + 0.03)
    # A lip of half the radius resists tipping and turning, and it is critically damped.
    assert model.geom_friction[lip] == pytest.approx(np.tile([0.0, 0.0075, 0.0075], (8, 1)))
    assert (model.geom_solref[lip, 1] == 1.0).all() and (model.geom_gap[lip] == 3e-3).all()


def test_a_heavier_load_is_refused_and_not_lifted(station):
    put(station, Box(mass=4.5, size=(0.1, 0.1, 0.1)))
    for behaviour in (Hover(object="thing"), Grasp(object="thing", force=42.0)):
        assert Trial(station, behaviour).fails_with("N, the object weighs 44.1 N")
    above, close = MoveToPose(pose=on_top(0.15)), CloseGripper(force=42.0)
    tree = Sequence(children=[OpenGripper(), above, MoveToPose(pose=on_top(0.101)), close])
    assert station.run(tree).status is NodeStatus.SUCCESS, tree.tip().feedback_message
    assert station.gripper.held == ("thing",)  # it is sealed, while the load stands
    assert Trial(station, Lift(height=0.2)).fails_with("the payload weighs")
    assert station.cell.pose("thing").translation[2] == pytest.approx(TABLE + 0.05, abs=2e-3)


def test_a_tug_below_the_holding_force_is_held_and_one_above_breaks_the_seal(station):
    picked(station, Box(mass=0.2))
    weight = 0.2 * 9.81
    tug(station, 36.0 - weight, 0.3)
    assert station.gripper.held == ("thing",) and station.gripper.steady
    tug(station, 44.0 - weight, 0.1)
    assert station.gripper.held == () and station.gripper.closed_on_nothing
    assert station.gripper.held_root() == 0 and not station.gripper.is_open
    assert station.gripper.forces == (0.0,)


@pytest.fixture
def still():
    """Give a cup of 42.4 N whose arm does not move, and a function that steps it before a box."""
    robot, cell = Robot(read_description(WITH_CUP), gripper=SuctionGripper), Cell()
    with cell.editing():
        cell.add(robot)
        cell.add(Box(size=(0.1, 0.1, 0.1)), pose((1.5, 0.0, 0.5)), name="thing", free=False)
    home, T_wt = cell.data.qpos.copy(), robot.tool_pose

    def step(number, away=None, aside=0.0):
        if away is not None:
            at = pin.SE3(np.eye(3), np.array([aside, 0.0, 0.05 + away]))
            cell.move("thing", T_wt * at, overlap=1.0)
        for _ in range(number):
            cell.data.qpos[:], cell.data.qvel[:] = home, 0.0
            cell.step(1)
        return abs(float(cell.data.actuator_force[robot.gripper.cup.ctrl]))

    return robot.gripper, step


def test_the_force_rises_in_50_ms_falls_in_20_ms_and_a_seal_needs_contact_within_500_ms(still):
    cup, step = still
    most = 60e3 * np.pi * 0.015**2
    step(1, away=1e-3)
    cup.close(20.0)
    assert [step(n) for n in (11, 10, 30)] == pytest.approx([most / 5, most / 50 * 20, 20.0])
    step(448)
    assert cup.status == "cup not sealed yet" and not cup.held and not cup.closed_on_nothing
    assert step(2) == 0.0 and cup.status == "cup found nothing that seals it"
    assert cup.closed_on_nothing and cup.is_free and not cup.is_open
    step(1, away=-2e-4)
    cup.close(20.0)
    step(23)
    assert not cup.held
    step(1)  # 42.4 N in 50 ms are 20 N in 24 ms
    assert cup.held == ("thing",) and cup.forces[0] > 0.0
    step(49)
    assert not cup.steady
    step(1)
    assert cup.steady
    cup.close(25.0)
    assert not cup.steady and step(8) == 25.0 and cup.steady
    cup.open()
    assert step(6) == pytest.approx(25.0 - 5 * most / 20) and not cup.is_open
    step(8)
    assert cup.is_open


def test_a_seal_breaks_after_the_contact_or_where_the_lip_is_not_covered_until_it_closes(still):
    cup, step = still
    for move, kept, lost in (
        ({"away": 1e-3}, 4, 3),  # 5 ms
        ({"away": -2e-4, "aside": 0.045}, 5, 2),  # it is checked every 10 ms
    ):  # fmt: skip
        step(1, away=-2e-4)
        cup.close(20.0)
        step(28)  # 4 ms after it was sealed
        assert cup.held
        step(kept, **move)
        assert cup.held
        step(lost)
        assert not cup.held and cup.status == "cup lost its seal"
        assert step(50, away=-2e-4) == 0.0 and not cup.held  # though it is in contact again


@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_a_cup_seals_3_mm_from_a_face_that_is_under_the_whole_lip(kind):
    corners = " ".join(f"{x} {y} {z}" for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-1, 0))
    shape = {"box": 'type="box" size="0.1 0.1 0.5" pos="0 0 -0.5"', "mesh": 'mesh="it" type="mesh"'}
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><asset><mesh name="it" vertex="{corners}"/></asset><worldbody>
        <site name="lip" pos="0.1 0.2 0.3" euler="150 20 30"/>
        <body mocap="true"><geom {shape[kind]}/></body><body mocap="true"><geom {shape[kind]}/>
        </body></worldbody></mujoco>"""
    )
    data, radius = mujoco.MjData(model), 0.012
    mujoco.mj_kinematics(model, data)
    T_wl = pin.SE3(data.site_xmat[0].reshape(3, 3), data.site_xpos[0])
    facing = pin.utils.rotate("y", np.pi)
    limit = 3e-3 + 0.5 * radius  # a curved face may be half a radius deeper at the lip
    for ahead, x, other, expected in (
        (0.0, 0.0, 9.0, True), (limit - 1e-4, 0.0, 9.0, True), (limit + 1e-4, 0.0, 9.0, False),
        (-2.9e-3, 0.0, 9.0, True), (-3.1e-3, 0.0, 9.0, False),
        (1e-3, 0.1 - 0.0121, 9.0, True), (1e-3, 0.1 - 0.0119, 9.0, False),
        (1e-3, 0.1, -0.1, True), (1e-3, 0.1, -0.12, False),  # two faces cover it together
    ):  # fmt: skip
        for body, at in enumerate((x, other)):
            T = T_wl * pin.SE3(facing, np.array([at, 0.001, ahead]))
            data.mocap_pos[body], data.mocap_quat[body] = T.translation, quat_wxyz(T)
        mujoco.mj_kinematics(model, data)
        assert seals(model, data, 0, radius, [0, 1]) == expected


def test_what_it_holds_is_known_to_everybody_goes_on_from_a_state_and_is_set_down(station):
    picked(station, Box(size=(0.05, 0.05, 0.05), mass=0.3))
    assert station.arm.payload.mass == pytest.approx(0.3)
    check_held(station)
    place = PlaceAt(object="thing", pose=pose((0.4, -0.2, TABLE)))
    assert station.run(place).status is NodeStatus.SUCCESS, place.feedback_message
    assert station.gripper.is_open and station.gripper.held == ()


def test_a_held_object_neither_slips_nor_sags_while_the_arm_holds_it_level(station):
    picked(station, Box(size=(0.05, 0.05, 0.05), mass=0.5))
    level = MoveToPose(pose=pose((0.5, 0.1, 1.4), (0.5**0.5, 0.0, 0.5**0.5, 0.0)), speed=0.3)
    assert station.run(level).status is NodeStatus.SUCCESS, level.feedback_message
    before = station.robot.tool_pose.actInv(station.cell.pose("thing"))
    station.cell.step(1000)
    moved = before.actInv(station.robot.tool_pose.actInv(station.cell.pose("thing")))
    assert np.linalg.norm(moved.translation) < 3e-5
    assert np.trace(moved.rotation) > 3.0 - 1e-6


def test_the_model_may_have_a_cup_of_its_own(parts, tmp_path):
    arm = WITH_CUP.read_text().replace("six_joints.urdf", str(ROBOTS / "six_joints.urdf"))
    arm = arm.partition("[tool]")[0]
    (tmp_path / "cup.xml").write_text(
        """<mujoco><worldbody><body name="pad">
          <geom type="cylinder" size="0.02 0.01" pos="0 0 0.01" mass="0.05"/>
          <geom type="box" size="0.03 0.01 0.004" pos="0 0 0.005" euler="0 0 45" mass="0.01"/>
          <site name="lip" pos="0 0 0.02" euler="0 0 45"/>
        </body></worldbody>
        <actuator><adhesion name="vacuum" body="pad" ctrlrange="0 2" gain="30"/></actuator>
        </mujoco>"""
    )
    tool = (
        '[tool]\nframe = "lip"\n[gripper]\nkind = "suction"\nmodel = "cup.xml"\nmount = "mount"\n'
    )
    (tmp_path / "arm.toml").write_text(arm + tool)
    station = build_station(parts, robot=str(tmp_path / "arm.toml"))
    assert station.gripper.max_force == pytest.approx(60.0)
    assert station.gripper.cup.radius == pytest.approx(0.02)
    picked(station, Box(size=(0.06, 0.06, 0.05), mass=0.5))
    (tmp_path / "arm.toml").write_text(arm + tool + 'actuator = "vacum"\n')
    with pytest.raises(RobotError, match="no adhesion actuator 'vacum'; did you mean 'vacuum'"):
        Robot(read_description(tmp_path / "arm.toml"), gripper=SuctionGripper)
    (tmp_path / "arm.toml").write_text(arm + tool)
    cup = (tmp_path / "cup.xml").read_text().replace("<geom", '<geom contype="0" conaffinity="0"')
    (tmp_path / "cup.xml").write_text(cup)
    with pytest.raises(RobotError, match="the cup '.*pad' has no collision geometry"):
        Robot(read_description(tmp_path / "arm.toml"), gripper=SuctionGripper)


def test_a_file_and_python_say_the_same():
    described = suction_gripper(diameter=0.03, pressure=60e3, length=0.06)
    assert read_description(WITH_CUP).gripper == described


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("pressure = 60e3\n", "", "'gripper.pressure' is missing"),
        ("diameter = 0.03\n", "", "'gripper.diameter' is missing"),
        ("length", "lenght", "'gripper.lenght' means nothing; did you mean 'length'"),
        ("length", "max_force = 3\nlength", "'gripper.max_force' follows from 'pressure'"),
        ("length = 0.06", "length = 0.029", "'gripper.length' is at least the diameter"),
        ("diameter = 0.03", "diameter = 0.005", "'gripper.diameter' .*0.005"),
        ("pressure = 60e3", "pressure = 0.0", "'gripper.pressure' .*0"),
    ],
)
def test_wrong_descriptions_are_refused_with_the_key(tmp_path, old, new, message):
    text = WITH_CUP.read_text().replace("six_joints.urdf", str(ROBOTS / "six_joints.urdf"))
    (tmp_path / "arm.toml").write_text(text.replace(old, new))
    with pytest.raises(RobotError, match=rf"arm.toml:\d+: key {message}"):
        Robot(read_description(tmp_path / "arm.toml"), gripper=SuctionGripper)


@pytest.mark.soak
@pytest.mark.parametrize("arm", [WITH_CUP, ON_UR5E])
@pytest.mark.parametrize("model", ["cube", "sphere"])
def test_pick_place_puts_all_into_the_basket(menagerie, tmp_path, monkeypatch, arm, model):
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    report = tmp_path / "report.json"
    options = ("--robot", arm, "--cycles", 20, "--report", report, "--set", f"cube={model}")
    assert run_program("run", "pick_place", "--quiet", *options) == 0
    cycles_run = json.loads(report.read_text())["cycles"]
    assert [cycle["placed"] for cycle in cycles_run] == [True] * 20
    assert not [c for cycle in cycles_run for c in cycle["unexpected_contacts"]]


@pytest.mark.parametrize("check", ROBOT_CONTRACT, ids=lambda check: check.__name__)
def test_an_arm_with_a_cup_keeps_the_contract_of_robots(check):
    check(RobotCase(read_description(WITH_CUP), SuctionGripper))
