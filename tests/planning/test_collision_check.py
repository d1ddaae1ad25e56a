"""Collision checks of goals and tool paths."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.collision import PATH_STEP
from bt_manip.exceptions import MotionError
from bt_manip.planning import ArcTo, LineTo, follow_tool_path, tool_paths
from bt_manip.planning.collision_check import sample_path

from .test_collision_free_motion import arm as arm


@pytest.mark.parametrize(
    "ask",
    [
        lambda arm: arm.move_to_configuration(arm.model.home),
        lambda arm: arm.move_linear(spatial.pointing_down((0.5, 0.25, 0.3), 0.0)),
    ],
)
def test_a_collision_at_the_start_that_blocks_the_motion_is_named(walled, arm, ask):
    deep = spatial.pointing_down((0.5, 0.25, -0.02), 0.0)
    arm.reset(walled.ik.solve(deep, arm.q).q)
    before = arm.get_state()
    with pytest.raises(MotionError, match=r"at the start 'panda/\w+' is \d+\.\d mm inside 'top'"):
        ask(arm)
    assert arm.get_state() == before


def test_a_goal_in_collision_is_refused_by_name_and_nothing_moves(walled, arm):
    inside = walled.ik.solve(walled.left, arm.q).q
    inside[1] += 0.3  # leans into the table
    before, depth = arm.get_state(), -1e3 * walled.world.collisions(inside)[0].distance
    message = rf"the target is in collision: 'panda/\w+' would be {depth:.1f} mm inside 'top'"
    with pytest.raises(MotionError, match=message):
        arm.move_to_configuration(inside)
    assert arm.get_state() == before


def test_a_blocked_tool_path_is_refused_with_its_free_share(walled, arm):
    arm.reset(arm.ik.nearest(walled.left, arm.model.home).q)
    aside = pin.SE3(walled.left.rotation, np.array([0.4, 0.25, 0.2]))
    through = pin.SE3(walled.left.rotation, np.array([0.4, -0.25, 0.2]))
    with pytest.raises(MotionError, match=r"the path is blocked after \d+ % .* 'wall'") as raised:
        arm.move_path([LineTo(aside), LineTo(through)], blend=0.03)
    assert raised.value.reason == "collision"
    first = np.linalg.norm(aside.translation - walled.left.translation)
    assert first / (first + 0.5) < raised.value.fraction < (first + 0.25) / (first + 0.5)
    assert not arm.moving


def test_an_arc_keeps_a_millimetre_of_clearance(arm):
    end = spatial.pointing_down((0.5, 0.35, 0.12), 0.0)
    with pytest.raises(MotionError, match="finger' would touch 'top'"):
        arm.move_path([ArcTo([0.5, 0.3, 0.0095 + 0.7e-3], end)])
    arm.move_path([ArcTo([0.5, 0.3, 0.0095 + 1.3e-3], end)])
    assert arm.moving
    arm.reset(arm.target)
    arm.move_linear(spatial.pointing_down((0.5, 0.35, 0.0095 + 0.5e-3), 0.0))  # to nearer by


def test_a_path_is_sampled_just_below_the_step_of_checks(arm):
    start = arm.model.pose(arm.q)
    (path,) = tool_paths(start, [LineTo(start * spatial.pose((0.0, 0.1, -0.15)))])
    curve = follow_tool_path(arm.ik, arm.q, path)
    steps = np.abs(np.diff(sample_path(curve, 200)[:, :7], axis=0))
    assert 0.9 * PATH_STEP < steps.max() <= PATH_STEP
