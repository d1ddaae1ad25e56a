"""Motions near the ends of the joint ranges, with velocity limits that shrink towards them."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.robots import Robot, panda
from bt_manip.trajectories import plan_stop, trajectory_from_state

from .watch import arm_of

NEAR = replace(panda(), near_offset=(0.3,) * 7, near_deceleration=(4.0,) * 7, limit_margin=0.02)


@pytest.fixture(scope="module")
def arm():
    return arm_of(NEAR)


def test_a_motion_to_the_end_of_the_range_is_slowed_only_there(arm):
    limits, middle = arm.model.limits, 0.5 * (arm.model.limits.lower + arm.model.limits.upper)
    goal = middle.copy()
    goal[0] = limits.upper[0]
    arm.reset(middle)
    arm.move_to_configuration(goal)
    times = np.arange(0.0, arm.remaining, 1e-3)
    q, v, _ = arm.trajectory.sample(times)
    assert v[:, 0].max() > 0.99 * limits.velocity[0]
    assert (v / limits.velocity_at(q, v)).max() <= 1.0
    again = trajectory_from_state(arm.trajectory.get_state())  # has the same limits
    stops = (plan_stop(motion, 0.3, arm.model) for motion in (arm.trajectory, again))
    for array, other in zip(
        *(stop.sample(np.arange(0.0, 0.5, 1e-3)) for stop in stops), strict=True
    ):
        np.testing.assert_array_equal(array, other)


def test_a_goal_where_the_controller_allows_no_velocity_is_refused(arm):
    goal = arm.model.home.copy()
    goal[0] = Robot(panda()).limits.upper[0] - 1e-3
    arm.reset()
    with pytest.raises(MotionError, match="joint 1"):
        arm.move_to_configuration(goal)


@pytest.mark.parametrize(
    ("joint", "sign", "steps"), [(0, -1.0, 100), (3, 1.0, 100), (3, -1.0, 100), (0, 1.0, 20)]
)
def test_servo_arrives_at_the_end_of_the_range_without_being_stopped(arm, joint, sign, steps):
    limits, goal = arm.model.limits, arm.model.home.copy()
    arm.reset(goal)
    goal[joint] += 9.0 * sign  # far beyond
    for _ in range(2000 // steps):
        arm.servo(goal, np.zeros(7), 1e-3 * steps)
        for _ in range(steps):
            arm.advance(1e-3)
            assert not arm.follower.stopping
            assert (limits.lower - 1e-9 <= arm.q).all() and (arm.q <= limits.upper + 1e-9).all()
            most = limits.velocity_at(arm.q, arm.v) * (1.0 + 1e-6)
            assert (np.abs(arm.v) <= most).all()
    assert arm.q[joint] == pytest.approx(goal.clip(limits.lower, limits.upper)[joint], abs=0.05)
