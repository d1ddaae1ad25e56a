"""The hand wraps its fingers around an object, holds it with a force, and says when it does not."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.behaviours import (
    CloseGripper,
    Drop,
    Grasp,
    Hover,
    IsHolding,
    Lift,
    OpenGripper,
    Reach,
)
from bt_manip.bt import NodeStatus, Sequence
from bt_manip.cell.objects import Box, Cube, Cylinder, Sphere
from bt_manip.robots import Robot, RobotError, read_description
from bt_manip.spatial import pose
from bt_manip.testing import Trial
from bt_manip_hands.hand import Hand
from tests.support.held import check_held

pytestmark = pytest.mark.usefixtures("hand_models")

ROBOT = "ur5e_allegro"
TABLE = 1.015  # [m]
FORCE = 8.0  # [N]


@pytest.fixture(scope="module")
def put(hand_models):
    """Give a function that returns the station, with an object at a random place on the table."""
    station = build_station(robot=ROBOT)
    start = station.get_state()

    def put(entity, seed=0):
        station.set_state(start)
        x, y, yaw = np.random.default_rng(seed).uniform([0.2, -0.3, -np.pi], [0.4, 0.3, np.pi])
        turn = (math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw))
        station.cell.add(entity, pose((x, y, TABLE + entity.rest_height), turn), name="thing")
        station.cell.step(100)
        return station

    return put


def pick():
    return Sequence(children=[
        OpenGripper(), Hover(object="thing"), Reach(object="thing"),
        Grasp(object="thing", force=FORCE), Lift(height=0.2), IsHolding(object="thing"),
    ])  # fmt: skip


def is_dropped(put, seed):
    """Return whether a cube of 6 cm ends in the basket."""
    station = put(Cube(size=0.06), seed)
    tree = Sequence(children=[pick(), Drop(container="basket", height=0.3)])
    return station.run(tree).status is NodeStatus.SUCCESS


def test_it_picks_a_cube_of_6_cm_and_drops_it(put):
    assert is_dropped(put, 0)


@pytest.mark.soak
def test_it_drops_at_least_15_of_20_cubes_of_6_cm_into_the_basket(put):
    assert sum(is_dropped(put, seed) for seed in range(20)) >= 15


@pytest.mark.parametrize(
    "entity",
    [Box(size=(0.08, 0.05, 0.06)), Cylinder(radius=0.03, height=0.08), Sphere(radius=0.035)],
    ids=lambda entity: entity.kind,
)
def test_it_picks_other_shapes_which_is_known_to_everybody_and_in_its_state(put, entity):
    station, tree = put(entity), pick()
    assert station.run(tree).status is NodeStatus.SUCCESS, tree.tip().feedback_message
    assert station.gripper.held == ("thing",)
    assert station.gripper.forces[0] == pytest.approx(FORCE, rel=0.3)
    model, data = station.cell.model, station.cell.data
    thing = station.cell.body_id("thing")
    touched = [
        c.geom for c in data.contact if thing in model.body_rootid[model.geom_bodyid[c.geom]]
    ]
    assert touched  # with the friction of the object, which is the larger one, not of the hand
    assert all(model.geom_friction[pair, 0].min() == 0.0 for pair in touched)
    assert station.arm.payload is not None
    check_held(station)


def test_it_notices_that_it_has_closed_on_nothing(put):
    station = put(Cube(size=0.06))
    close = CloseGripper(force=FORCE)
    assert station.run(close).status is NodeStatus.SUCCESS
    assert station.gripper.closed_on_nothing and station.gripper.held == ()
    assert not station.gripper.moving
    station.gripper.open()
    assert station.gripper.moving and not station.gripper.is_open
    station.gripper.stop()
    assert not station.gripper.moving and not station.gripper.is_open
    assert station.run(OpenGripper()).status is NodeStatus.SUCCESS
    station.gripper.stop()
    assert not station.gripper.moving and station.gripper.is_open
    grasp = Grasp(object="thing", force=FORCE)
    assert Trial(station, grasp).fails_with("the gripper closed without gripping 'thing'")


def test_an_object_that_is_too_wide_fails_with_its_width(put):
    hovering = Trial(put(Box(size=(0.12, 0.12, 0.12))), Hover(object="thing"))
    assert hovering.fails_with("'thing' does not fit the hand: it is")


def test_wrong_keys_of_a_description_are_refused(tmp_path):
    from bt_manip_hands.plugin import ROBOTS

    text = (ROBOTS / "ur5e_allegro.toml").read_text()
    (tmp_path / "arm.toml").write_text(text.replace("stiffness =", "stifness ="))
    with pytest.raises(RobotError, match=r"arm.toml:\d+: key 'gripper.stiffness' is missing"):
        Robot(read_description(tmp_path / "arm.toml"), gripper=Hand)


def stepped(force, seconds, held=(), s=0.5, state="closing"):
    """Return a hand after some time with a force between thumb and object."""
    data = SimpleNamespace(sensordata=[0.25 * force, 9.0, 0.75 * force])  # of two links
    model = SimpleNamespace(opt=SimpleNamespace(timestep=1e-3))
    hand = SimpleNamespace(
        robot=SimpleNamespace(mj_data=data, mj_model=model), state=state, held=held,
        _adr=[0, 2], _asked=FORCE, _s=s, _time=0.0, _idle=0.0,
    )  # fmt: skip
    for _ in range(round(1e3 * seconds)):
        Hand.after_substep(hand, None, None)
    return hand


def test_it_closes_in_0_8_s_and_more_slowly_the_nearer_the_force_is_to_the_asked_one():
    for share, rate in ((0.0, 1.0), (0.5, 0.5), (0.9, 0.1), (1.1, -0.1), (3.0, -1.0)):
        assert vars(stepped(share * FORCE, 0.1))["_s"] == pytest.approx(0.5 + rate * 0.1 / 0.8)
    assert vars(stepped(0.0, 0.1, state="open"))["_s"] == pytest.approx(0.5 - 0.1 / 0.8)
    ends = stepped(0.0, 0.5), stepped(0.0, 0.5, state="open"), stepped(0.0, 0.5, state="stopped")
    assert [vars(hand)["_s"] for hand in ends] == [1.0, 0.0, 0.5]


def test_it_is_steady_after_100_ms_near_the_force_and_has_closed_on_nothing_after_300_ms():
    thing = ("thing",)
    for share, seconds, held, steady in (
        (0.79, 0.15, thing, False), (0.81, 0.099, thing, False), (0.81, 0.1, thing, True),
        (1.29, 0.1, thing, True), (1.31, 0.15, thing, False), (1.0, 0.15, (), False),
    ):  # fmt: skip
        assert Hand.steady.fget(stepped(share * FORCE, seconds, held)) == steady
    for share, seconds, s, held, nothing in (
        (0.0, 0.298, 1.0, (), False), (0.0, 0.302, 1.0, (), True),  # closed
        (0.81, 0.298, 0.5, (), False), (0.81, 0.302, 0.5, (), True),  # thumb on finger
        (0.79, 0.5, 0.5, (), False), (0.81, 0.5, 0.5, thing, False), (0.0, 0.5, 1.0, thing, True),
    ):  # fmt: skip
        hand = stepped(share * FORCE, seconds, held, s)
        assert Hand.closed_on_nothing.fget(hand) == nothing


def test_its_joints_are_springs_to_a_posture_with_limited_torque_and_it_is_open_within_60_mrad(put):
    station = put(Cube(size=0.06))
    given, data = station.robot.description.gripper.parameters, station.cell.data
    joints = [
        data.joint(station.robot.find("joint", name).full_identifier) for name in given["joints"]
    ]
    opened, closed, qpos = np.array(given["open"]), np.array(given["closed"]), data.qpos.copy()
    station.gripper.set_opening(data.qpos, 0.7)
    q = np.array([float(joint.qpos[0]) for joint in joints])
    assert q == pytest.approx(opened + 0.3 * (closed - opened))
    for off in (0.059, -0.061):
        data.qpos[:] = qpos
        station.gripper.set_opening(data.qpos)
        joints[5].qpos += off
        assert station.gripper.is_open == (abs(off) < 0.06)
    rng = np.random.default_rng(0)
    away = rng.choice([-1.0, 1.0], 16) * rng.uniform(0.01, 0.5, 16)
    for joint, position in zip(joints, opened + away, strict=True):
        joint.qpos, joint.qvel = position, 0.0
    station.cell.step(1)
    torque = [float(joint.qfrc_actuator[0]) for joint in joints]
    assert torque == pytest.approx(np.clip(-4.0 * away, -0.7, 0.7), abs=1e-6)
