"""Blends: the next motion begins before the arm has come to rest, inside all limits."""

import numpy as np
import pytest

from bt_manip.arm import Arm
from bt_manip.planning import tool_distance
from bt_manip.spatial import pointing_down

from .watch import Watch

CORNER = np.array([0.5, 0.2, -0.3, -1.7, 0.3, 1.9, 0.9])
RADIUS = 0.2


def run_to_blend(watch, radius=RADIUS):
    """Advance an arm to where the rest of its motion is within the blend radius."""
    while not watch.arm.ends_within(radius):
        watch.run(10)
    assert watch.arm.moving
    watch.arm.blend_radius = radius


def line_down(arm, z=0.25):
    T_wt = arm.model.pose(arm.target).copy()
    T_wt.translation[2] -= z
    arm.move_linear(T_wt)


def joints_on(arm):
    arm.move_to_configuration(arm.target + [0.4, 0.3, 0.1, -0.2, 0.0, 0.3, 0.2])


def blend_at_corner(watch, next_motion):
    """Move to the corner and blend; return the duration with a stop in the corner, and its rows."""
    arm = watch.arm
    arm.move_to_configuration(CORNER)
    other = Watch(Arm(arm.robot, ik=arm.ik))
    other.arm.set_state(arm.get_state())
    other.run()
    next_motion(other.arm)
    other.run()
    run_to_blend(watch)
    start = len(watch.rows)
    next_motion(arm)
    assert np.array_equal(arm.target, other.arm.target)
    return len(other.rows), start


@pytest.mark.parametrize("next_motion", [line_down, joints_on])
def test_a_blend_keeps_all_limits_is_shorter_and_ends_at_the_same_target(watch, next_motion):
    arm = watch.arm
    with_stop, start = blend_at_corner(watch, next_motion)
    target = arm.target
    watch.run()
    watch.check()
    assert watch.worst_effort() < 1.0
    assert len(watch.rows) < with_stop - 50  # steps
    assert arm.q == pytest.approx(target, abs=1e-9)
    q = np.array([row[0] for row in watch.rows])
    at_corner = tool_distance(arm.model, q[start:], arm.model.pose(CORNER).copy())
    inside = at_corner <= RADIUS + 1e-9
    assert inside[: inside.argmin()].all() and 0.0 < at_corner.min() < RADIUS
    limits = arm.model.limits
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), 1):
        differences = np.abs(np.diff(q, order, axis=0)) / 1e-3**order  # of positions alone
        assert (differences <= limit * 1.001).all()
    if next_motion is line_down:  # which it does not leave after the blend
        corner = arm.model.pose(CORNER).translation.copy()
        outside = [arm.model.pose(row).translation - corner for row in q[-100:]]
        assert np.abs(np.array(outside)[:, :2]).max() < 1e-4
        assert outside[0][2] > outside[-1][2] == pytest.approx(-0.25, abs=1e-4)


def test_a_rotation_counts_as_the_travel_of_a_point_beside_the_tool(arm, rng):
    q, T = rng.normal(size=(4, 7)), arm.model.pose(CORNER).copy()
    expected = []
    for one in q:
        other = arm.model.pose(one).copy()
        turned = np.arccos(0.5 * (np.trace(T.rotation.T @ other.rotation) - 1.0))
        expected.append(max(np.linalg.norm(other.translation - T.translation), 0.2 * turned))
    assert tool_distance(arm.model, q, T) == pytest.approx(expected)
    turn = CORNER + 1.5 * np.eye(7)[6]  # about the axis of the tool
    assert tool_distance(arm.model, turn[None], T) == pytest.approx([0.3])


def test_the_rest_of_a_motion_is_within_a_radius_at_the_earliest_after_a_tenth_of_it(watch):
    arm = watch.arm
    arm.move_to_configuration(CORNER)
    T_target = arm.model.pose(CORNER).copy()
    (length,) = tool_distance(arm.model, arm.q[None], T_target)
    while arm.moving:
        (left,) = tool_distance(arm.model, arm.q[None], T_target)
        for radius in (0.08, 10.0):
            assert arm.ends_within(radius) == (left <= min(radius, 0.9 * length))
        watch.run(15)
    assert arm.ends_within(0.0)


def test_an_arm_that_pauses_does_not_end_within_a_large_radius(watch):
    arm = watch.arm
    arm.move_to_configuration(CORNER)
    watch.run(200)
    arm.pause()
    assert not arm.ends_within(10.0)
    watch.run()
    assert arm.paused and not arm.ends_within(10.0)


def test_a_wall_inside_the_corner_is_passed_with_its_clearance(walled):
    corner, across = (pointing_down((0.5, y, 0.5), 0.0) for y in (0.17, -0.17))
    below = pointing_down((0.5, 0.17, 0.12), 0.0)
    touched = {}
    for world in (None, walled.world):
        arm = Arm(walled.robot, ik=walled.ik, world=world)
        arm.reset(walled.ik.nearest(below, np.array(walled.robot.description.home)).q)
        watch = Watch(arm)
        arm.move_linear(corner)
        run_to_blend(watch, 0.35)
        arm.move_linear(across)
        watch.run()
        watch.check()
        touched[world] = any(walled.world.collisions(row[0]) for row in watch.rows[::5])
        assert arm.model.pose(arm.q).translation == pytest.approx(across.translation, abs=1e-4)
    assert touched == {None: True, walled.world: False}
