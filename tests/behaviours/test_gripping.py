"""Behaviours that use the fingers: they hold by force alone, or say why not."""

import json
from functools import partial

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.behaviours import CloseGripper, Drop, Grasp, IsHolding, Lift, OpenGripper, payload_of
from bt_manip.bt import NodeStatus
from bt_manip.cell import Cell, is_in
from bt_manip.cell.objects import ModelObject

RUNNING, SUCCESS, FAILURE = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE


def test_grasp_holds_with_the_asked_force_for_50_ms_and_the_object_is_the_payload(
    at_the_cube, trial
):
    grasping = trial(Grasp(object="cube", force=40.0))
    pressed = 0
    while grasping.tick() is RUNNING:
        assert "fingers press with" in grasping.behaviour.feedback_message
        pressed += min(at_the_cube.gripper.forces) >= 0.95 * 40.0
    assert grasping.behaviour.status.name == "SUCCESS" and pressed >= 4
    for force in at_the_cube.gripper.forces:
        assert 0.95 * 40.0 <= force <= 1.2 * 40.0
    payload = at_the_cube.arm.payload
    assert payload.mass == pytest.approx(0.0565)
    # The cube's centre hangs 15 mm beyond the tool's centre point, on the tool's z axis.
    assert payload.com == pytest.approx([0, 0, 0.015], abs=1.5e-3)
    assert at_the_cube.controller.payload == payload


def test_a_gripper_closes_with_the_preferred_force_or_with_80_percent_of_a_smaller_one(station):
    gripper = station.gripper
    for preferred, force in ((0.9, 0.9), (1.0, 1.0), (1.1, 0.8)):
        found = gripper.default_force(preferred * gripper.max_force)
        assert found == pytest.approx(force * gripper.max_force)


HAMMER = """<mujoco><worldbody><body name="hammer">
  <geom type="box" size="0.01 0.02 0.1" pos="0.01 -0.02 0.03" euler="20 40 -30" mass="0.3"/>
  <body pos="0.02 0.01 0.12" euler="10 -50 70">
    <geom type="box" size="0.05 0.03 0.02" pos="0.01 0.03 0" euler="0 30 15" mass="0.7"/>
  </body></body></worldbody></mujoco>"""


def test_the_payload_of_several_bodies_is_their_composite_inertia(tmp_path):
    (tmp_path / "hammer.xml").write_text(HAMMER)
    cell = Cell()
    pose = pin.SE3(pin.rpy.rpyToMatrix(0.4, -0.7, 1.1), np.array([0.3, -0.2, 0.9]))
    name = cell.add(ModelObject(str(tmp_path / "hammer.xml")), pose)
    T_wt = pin.SE3(pin.rpy.rpyToMatrix(-1.2, 0.3, 0.5), np.array([0.4, 0.1, 0.7]))
    payload = payload_of(cell, name, T_wt)
    model, data, bodies = cell.model, cell.data, np.flatnonzero(cell.model.body_mass)
    com = np.average(data.xipos[bodies], axis=0, weights=model.body_mass[bodies])
    inertia = np.zeros((3, 3))
    for b in bodies:
        R, d = data.ximat[b].reshape(3, 3), data.xipos[b] - com
        inertia += R @ np.diag(model.body_inertia[b]) @ R.T
        inertia += model.body_mass[b] * (d @ d * np.eye(3) - np.outer(d, d))
    assert payload.mass == pytest.approx(1.0)
    np.testing.assert_allclose(payload.com, T_wt.actInv(com), atol=1e-12)
    expected = T_wt.rotation.T @ inertia @ T_wt.rotation
    np.testing.assert_allclose(payload.inertia, expected, atol=1e-12)


def test_grasp_yields_where_the_fingers_press_on_the_table(at_the_cube, trial):
    arm, cell = at_the_cube.arm, at_the_cube.cell
    down = arm.robot.tool_pose
    down.translation[2] -= 0.031
    arm.move_linear(down, speed=0.2, contact=True)
    at_the_cube.step_until(lambda: not arm.moving)
    cell.step(300)
    assert not arm.undisturbed
    assert trial(Grasp(object="cube")).until_done() is SUCCESS
    cell.step(100)
    assert arm.undisturbed
    assert trial(Lift(height=0.1)).until_done() is SUCCESS


def test_grasp_of_nothing_fails_when_the_fingers_meet(trial):
    assert trial(Grasp(object="cube")).fails_with("closed without gripping 'cube'")


def test_grasp_that_finds_another_object_says_which(at_the_cube, trial):
    cube = at_the_cube.models.create("cube")
    at_the_cube.cell.add(cube, spatial.pose((0.3, -0.2, 1.04)), name="other")
    assert trial(Grasp(object="other")).fails_with("holds cube, not 'other'")


def test_grasp_without_patience_fails_with_the_forces_it_got(at_the_cube, trial):
    assert trial(Grasp(object="cube", patience=0.1)).fails_with("no steady grip after 0.1 s")


def test_open_gripper_lets_go_of_what_is_held_and_forgets_the_payload(with_the_cube, trial):
    assert trial(IsHolding(object="cube")).tick() is SUCCESS
    assert trial(IsHolding(object="ball")).fails_with("holds cube, not 'ball'")
    with_the_cube.cell.data.time += 100.0  # patience counts from the start
    opening = trial(OpenGripper())
    assert opening.tick() is RUNNING
    assert opening.until_done() is SUCCESS
    assert with_the_cube.gripper.width > 0.079
    assert with_the_cube.arm.payload is None and with_the_cube.controller.payload is None
    assert trial(IsHolding(object="cube")).fails_with("holds nothing")


def test_open_gripper_that_something_holds_fails_with_the_width(with_the_cube, trial):
    opening = trial(OpenGripper(patience=0.02))
    assert opening.fails_with("the gripper is not open after 0.02 s (fingers")


def test_close_gripper_closes_on_nothing_too_if_it_has_the_time(station, trial):
    assert trial(CloseGripper(patience=0.05)).fails_with("after 0.05 s")
    closing = trial(CloseGripper())
    assert closing.tick() is RUNNING
    assert closing.until_done() is SUCCESS
    assert station.gripper.width < 2e-3


@pytest.mark.parametrize(
    ("behaviour", "ticks"),
    [(CloseGripper, 6), (partial(Grasp, object="cube"), 6), (OpenGripper, 12)],
)
def test_halted_fingers_stay_where_they_are(station, trial, behaviour, ticks):
    if behaviour is OpenGripper:
        assert trial(CloseGripper()).until_done() is SUCCESS
    moving = trial(behaviour())
    for _ in range(ticks):
        assert moving.tick() is RUNNING
    moving.tree.halt()
    station.cell.step(100)
    width = station.gripper.width
    station.cell.step(100)
    assert 0.005 < width < 0.075
    assert station.gripper.width == pytest.approx(width, abs=2e-4)


def test_drop_succeeds_when_the_object_rests_inside_the_container(with_the_cube, trial):
    cell = with_the_cube.cell
    dropping = trial(Drop(container="basket"))
    while dropping.tick() is RUNNING:
        assert not is_in(cell, "cube", "basket") or cell.contacts.partners("cube")
    assert is_in(cell, "cube", "basket")
    assert with_the_cube.gripper.is_free and with_the_cube.arm.payload is None
    assert trial(Lift(height=0.05)).until_done() is SUCCESS  # nothing is lost
    inside = cell.pose("basket").actInv(cell.pose("cube")).translation
    assert np.abs(inside[:2]).max() < 0.1 and 0.0 < inside[2] < 0.1


def test_drop_that_cannot_let_go_or_without_its_container_says_why(with_the_cube, trial):
    assert trial(Drop(container="baskett")).fails_with("did you mean 'basket'")
    assert with_the_cube.gripper.held == ("cube",)
    assert trial(Drop(container="basket", patience=0.01)).fails_with("touches cube")


def test_drop_tilts_the_tool_where_an_obstacle_blocks_all_vertical_poses(with_the_cube, trial):
    wall = with_the_cube.models.nominal("wall", size=(0.08, 0.08, 0.3))
    with_the_cube.cell.add(wall, spatial.pose((0.52, 0.092, 1.227)), name="obstacle")
    assert trial(Drop(container="basket")).until_done() is SUCCESS
    assert not with_the_cube.cell.contact_monitor.summary().unexpected
    assert with_the_cube.robot.tool_pose.rotation[2, 2] == pytest.approx(-np.cos(0.5), abs=0.01)


def test_drop_beside_the_container_fails_with_what_the_object_touches(with_the_cube, trial):
    dropping = trial(Drop(container="basket"))
    dropping.tick_until(lambda: "opening" in dropping.behaviour.feedback_message)
    with_the_cube.cell.move("basket", spatial.pose((-0.6, 0.0, 0.0)))
    assert dropping.fails_with("'cube' touches")
    assert with_the_cube.arm.payload is None


@pytest.mark.parametrize(
    ("behaviour", "remaining"),
    [(Lift(height=0.1), 0.0), (Lift(height=0.02), 0.02), (Drop(container="basket"), 0.0)],
)
def test_a_motion_that_loses_its_object_stops_and_fails(with_the_cube, trial, behaviour, remaining):
    moving, arm = trial(behaviour), with_the_cube.arm
    for _ in range(10):
        assert moving.tick() is RUNNING
    moving.tick_until(lambda: not remaining or arm.remaining < remaining)
    with_the_cube.cell.move("cube", spatial.pose((0.3, -0.2, 1.04)))
    assert moving.fails_with("'cube' was lost during the motion; it touches 'table'")
    assert arm.payload is None
    with_the_cube.cell.step(300)
    assert not arm.moving


def test_a_motion_whose_object_vanishes_fails(with_the_cube, trial):
    lifting = trial(Lift(height=0.1))
    lifting.tick()
    with_the_cube.cell.remove("cube")
    assert lifting.fails_with("'cube' was lost during the motion: it is no longer in the cell")


def test_contacts_interrupted_for_less_than_50_ms_are_no_loss(with_the_cube, trial, monkeypatch):
    gripper, held = type(with_the_cube.gripper), type(with_the_cube.gripper).held.fget
    lifting = trial(Lift(height=0.1))
    lifting.tick()
    monkeypatch.setattr(gripper, "held", property(lambda self: ()))
    for _ in range(5):
        assert lifting.tick() is RUNNING
    monkeypatch.setattr(gripper, "held", property(held))
    assert lifting.until_done() is SUCCESS


@pytest.mark.parametrize("ticks", [118, 124])
def test_a_drop_continues_from_its_state_bit_for_bit(with_the_cube, trial, ticks):
    station = with_the_cube
    dropping = trial(Drop(container="basket"))
    for _ in range(ticks):
        assert dropping.tick() is RUNNING
    state = json.loads(json.dumps([station.get_state(), dropping.tree.get_state()]))
    ends = []
    for again in (dropping, trial(Drop(container="basket"))):
        station.set_state(state[0])
        again.tree.set_state(state[1])
        assert again.until_done() is SUCCESS
        ends.append((station.cell.time, station.cell.state_bytes()))
    assert ends[0] == ends[1]
