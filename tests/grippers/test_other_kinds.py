"""The gripper of the template, without fingers, does all that one has to; so does none at all."""

import importlib
import re
from dataclasses import replace
from pathlib import Path

import pytest

from bt_manip import build_station
from bt_manip.behaviours import (
    CloseGripper,
    Drop,
    Grasp,
    Hover,
    IsHolding,
    Lift,
    MoveHome,
    MoveToPose,
    OpenGripper,
    PlaceAt,
    PlaceOn,
    Reach,
)
from bt_manip.bt import NodeStatus, Sequence
from bt_manip.cell.objects import Cube, Sphere
from bt_manip.models import bundled_path, bundled_root
from bt_manip.spatial import pose
from bt_manip.testing import Trial
from tests.support.held import check_held

ARM = """
model = "arm.xml"
arm_joints = ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7"]
home = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
velocity = 2.0
acceleration = 7.5
jerk = 4000.0
[tool]
frame = "tool"
"""
MAGNET = """
[gripper]
kind = "gear"
face = "face"
max_force = 60.0
"""
FACE = """<body name="face" pos="0 0 0.0634">
  <geom type="cylinder" size="0.015 0.02" pos="0 0 0.02" mass="0.1" gap="0.004"/>
</body>"""


@pytest.fixture(scope="module")
def parts(parts):
    """Give the built-in parts and the magnet of the template of a gripper."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(bundled_root("templates") / "gripper")
        gear = importlib.import_module("bt_manip_gear.gear")
        yield replace(parts, grippers=parts.grippers.with_part("gear", gear.Gear))


@pytest.fixture(scope="module")
def build(parts, tmp_path_factory):
    """Build a station with the Panda's arm, with what is given in place of its fingers."""

    def make(face, gripper):
        text = Path(bundled_path("panda/panda.xml")).read_text()
        text = re.sub(r'<body name="left_finger".*?</body>', face, text, flags=re.DOTALL)
        text = re.sub(r'<body name="right_finger".*?</body>', "", text, flags=re.DOTALL)
        text = re.sub(r"<(motor|exclude) [^>]*finger[^>]*/>", "", text)
        folder = tmp_path_factory.mktemp("arm")
        (folder / "arm.xml").write_text(text)
        (folder / "bare.toml").write_text(ARM + gripper)
        return build_station(parts, robot=str(folder / "bare.toml"))

    return make


@pytest.fixture(scope="module")
def built(build):
    """Give both stations, each with its state at the start."""
    stations = build(FACE, MAGNET), build("", "")
    return [(station, station.get_state()) for station in stations]


@pytest.fixture
def with_magnet(built):
    return as_built(*built[0])


@pytest.fixture
def without(built):
    return as_built(*built[1])


def as_built(station, start):
    station.set_state(start)
    return station


def place(station, entity=None):
    station.cell.add(entity or Cube(), pose((0.45, 0.1, 1.05)), name="thing")
    station.cell.step(300)


def test_what_it_holds_is_known_to_everybody_goes_on_from_a_state_and_is_set_down(with_magnet):
    station = with_magnet
    place(station)
    tree = Sequence(children=[Hover(object="thing"), Reach(object="thing"),
                              Grasp(object="thing", force=20.0), Lift(height=0.2)])  # fmt: skip
    assert station.run(tree).status is NodeStatus.SUCCESS
    assert station.gripper.held == ("thing",)
    assert station.arm.payload.mass == pytest.approx(0.0565, rel=0.1)
    check_held(station)  # its face may touch the cube
    place_at = PlaceAt(object="thing", pose=pose((0.45, -0.2, 1.015)))
    assert station.run(place_at).status is NodeStatus.SUCCESS
    assert station.gripper.is_open and station.gripper.held == ()


def test_its_failures_say_what_it_is_at(with_magnet):
    place(with_magnet, Sphere())
    for behaviour, reason in (
        (Hover(object="thing"), "'thing' has no flat top"),
        (Grasp(object="thing", force=20.0), "no steady grip after 2 s: presses with 0.0 N at most"),
        (Grasp(object="thing", force=80.0), "the gripper holds with up to 60 N, not 80 N"),
    ):
        assert Trial(with_magnet, behaviour).fails_with(reason)


def test_a_wrong_parameter_is_found_before_anything_moves(build):
    with pytest.raises(Exception, match="bare.toml:.*'gripper.body' means nothing"):
        build(FACE, MAGNET + 'body = "x"\n')
    with pytest.raises(Exception, match="unknown gripper 'gaer'; did you mean 'gear'"):
        build(FACE, MAGNET.replace('"gear"', '"gaer"'))


def test_an_arm_without_a_gripper_moves_and_its_state_comes_back(without):
    assert without.robot.gripper is None and without.infrastructure["gripper"] is None
    up = pose((0.45, 0.1, 1.3), (0.0, 1.0, 0.0, 0.0))
    assert without.run(MoveToPose(pose=up)).status is NodeStatus.SUCCESS
    state = without.get_state()
    assert without.run(MoveHome()).status is NodeStatus.SUCCESS
    ended = without.cell.state_bytes()
    without.set_state(state)
    assert without.run(MoveHome()).status is NodeStatus.SUCCESS
    assert without.cell.state_bytes() == ended
    assert without.cell.contact_monitor.summary().unexpected == ()


def test_what_needs_a_gripper_fails_and_says_that_there_is_none(without):
    place(without)
    for behaviour in (
        OpenGripper(), CloseGripper(), Grasp(object="thing"), IsHolding(object="thing"),
        Hover(object="thing"), Reach(object="thing"), Drop(container="basket"),
        PlaceOn(object="thing", support="table"),
    ):  # fmt: skip
        assert Trial(without, behaviour).fails_with("robot 'bare' has no gripper")


def test_an_arm_without_a_gripper_touches_things_unexpectedly(without):
    without.cell.add(Cube(), without.robot.tool_pose * pose((0.0, 0.0, 0.0)), name="thing")
    without.cell.step()
    assert without.cell.contact_monitor.summary().unexpected == (("bare/hand", "thing"),)
