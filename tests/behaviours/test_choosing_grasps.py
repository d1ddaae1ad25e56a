"""Hover and Reach take a grasp that fits the object, its neighbours and the arm."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.behaviours import Grasp, Hover, IsHolding, Lift, Reach
from bt_manip.bt import NodeStatus
from bt_manip.cell.objects import Box, Cube, Cylinder, Wall
from bt_manip.robots import GraspCandidate

TABLE = 1.015  # [m] height of its surface


@pytest.fixture
def cleared(station):
    """Give the station with nothing to grip on its table."""
    station.cell.remove("cube")
    return station


def put(station, thing, x, y, *, yaw=0.0, name="it", **options):
    turn = (np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw))
    z = TABLE + thing.rest_height
    station.cell.add(thing, spatial.pose((x, y, z), turn), name=name, **options)
    station.cell.step(50)


def pick(station, trial, *, grasp=Grasp, lift=0.05):
    """Pick 'it', and give how the tool points at the grip."""
    z = station.cell.pose("it").translation[2]
    trial(Hover(object="it", height=0.15)).tick_until("SUCCESS")
    trial(Reach(object="it")).tick_until("SUCCESS")
    assert not station.cell.contact_monitor.summary().unexpected
    pointing = station.robot.tool_pose.rotation[:, 2].copy()
    trial(grasp(object="it")).tick_until("SUCCESS")
    trial(Lift(height=lift)).tick_until("SUCCESS")
    trial(IsHolding(object="it")).tick_until("SUCCESS")
    assert station.cell.pose("it").translation[2] > z + 0.8 * lift
    return pointing


def test_hovering_no_higher_than_the_grip_is_being_at_the_grip(station, trial):
    trial(Hover(object="cube", height=0.015)).tick_until("SUCCESS")
    trial(Grasp(object="cube")).tick_until("SUCCESS")
    trial(IsHolding(object="cube")).tick_until("SUCCESS")


def test_reach_takes_the_grasp_that_hover_gave_also_at_a_height_over_the_object(station, trial):
    hovering = trial(Hover(object="cube", height=0.15, grasp="{grasp}"))
    hovering.tick_until("SUCCESS")
    text = hovering.tree.blackboard["grasp"]
    T_wt = station.cell.pose("cube") * GraspCandidate.from_text(text).T_ot
    for ports, above in (({"height": 0.06}, 0.06 - 0.015), ({}, 0.0)):
        trial(Reach(object="cube", grasp=text, **ports)).tick_until("SUCCESS")
        expected = spatial.pose((0.0, 0.0, above)) * T_wt
        error = pin.log6(expected.actInv(station.robot.tool_pose)).np
        assert np.abs(error).max() < 5e-3


def test_what_is_too_wide_fails_with_width_and_stroke_and_nothing_moves(cleared, trial):
    put(cleared, Box(size=(0.1, 0.12, 0.09)), 0.4, 0.1)
    q = cleared.arm.q_ref
    hovering = trial(Hover(object="it"))
    assert hovering.fails_with("at least 90 mm wide; the fingers open to 80 mm")
    assert (cleared.arm.q_ref == q).all()


def test_a_box_is_gripped_across_the_side_that_fits(cleared, trial):
    put(cleared, Box(size=(0.14, 0.03, 0.04)), 0.4, 0.1, yaw=0.7)
    pick(cleared, trial)
    along = cleared.cell.pose("it").rotation[:, 0]
    assert abs(cleared.robot.tool_pose.rotation[:, 1] @ along) < 0.02


@pytest.mark.parametrize("offset", [(0.066, 0.0), (0.0, 0.066)])
def test_a_cube_between_two_others_is_gripped_by_its_free_faces(station, trial, offset):
    T_wo = station.cell.pose("cube")
    for name, sign in (("one", 1.0), ("two", -1.0)):
        beside = spatial.pose((sign * offset[0], sign * offset[1], 0.0))
        station.cell.add(Cube(), T_wo * beside, name=name)
    station.cell.step()
    for behaviour in (Hover(object="cube", height=0.15), Reach(object="cube")):
        trial(behaviour).tick_until("SUCCESS")
        assert not station.cell.contact_monitor.summary().unexpected
    towards = T_wo.rotation @ np.array([*offset, 0.0]) / 0.066
    assert abs(station.robot.tool_pose.rotation[:, 1] @ towards) < 0.1


def test_under_a_roof_a_thing_is_gripped_from_beside(cleared, trial):
    put(cleared, Cylinder(radius=0.02, height=0.12), 0.45, 0.1)
    roof = Box(size=(0.3, 0.3, 0.02))
    T_wr = spatial.pose((0.5, 0.1, TABLE + 0.25))
    cleared.cell.add(roof, T_wr, name="roof", free=False)
    cleared.cell.step(10)
    pointing = pick(cleared, trial)
    assert pointing[2] > -0.8, "it does not come from above"


def test_a_cube_at_a_wall_is_gripped_by_the_faces_beside_it(station, trial):
    T_wo = station.cell.pose("cube")
    place = T_wo * spatial.pose((0.025 + 0.02 + 0.006, 0.0, 0.0))
    place.translation[2] = TABLE
    station.cell.add(Wall(size=(0.04, 0.3, 0.1)), place, name="wall")
    station.cell.step()
    for behaviour in (Hover(object="cube", height=0.2), Reach(object="cube")):
        trial(behaviour).tick_until("SUCCESS")
        assert not station.cell.contact_monitor.summary().unexpected
    assert abs(station.robot.tool_pose.rotation[:, 1] @ T_wo.rotation[:, 0]) < 0.1


def test_over_what_stands_fixed_the_tool_only_points_down(station, trial):
    trial(Hover(object="basket", height=0.25)).tick_until("SUCCESS")
    assert station.robot.tool_pose.rotation[:, 2] == pytest.approx([0, 0, -1], abs=5e-3)


def test_an_automatic_height_is_the_first_that_the_arm_reaches(station, trial):
    assert trial(Hover(object="cube")).until_done() is NodeStatus.SUCCESS
    above = station.robot.tool_pose.translation - station.cell.pose("cube").translation
    assert above[2] == pytest.approx(0.4, abs=5e-3)
