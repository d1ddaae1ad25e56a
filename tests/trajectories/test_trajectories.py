"""Derivatives are held against finite differences, distances against hand calculations."""

import json

import numpy as np
import pytest

from bt_manip.robots import JointLimits
from bt_manip.trajectories import (
    JointTrajectory,
    PathTrajectory,
    SequenceTrajectory,
    SplinePath,
    StraightPath,
    limit_use,
    trajectory_from_state,
)
from bt_manip.trajectories.kinematic_limits import KinematicLimits
from bt_manip.trajectories.motion_profile import (
    joint_profiles,
    profile_to_position,
    profile_to_velocity,
)

ONE = np.ones(2)
LIMITS = JointLimits(-3 * ONE, 3 * ONE, 2 * ONE, 5 * ONE, 100 * ONE, ONE)
BOUNDS = KinematicLimits.of_joints(LIMITS)
REST = (np.zeros(2), np.zeros(2), np.zeros(2))
MOVING = (np.array([0.1, -0.2]), np.array([1.5, -0.5]), np.array([2.0, -4.0]))


def joint_trajectory(start=MOVING, target=(1.0, 1.2)):
    limits = LIMITS.velocity, LIMITS.acceleration, LIMITS.jerk
    return JointTrajectory(joint_profiles(start, np.array(target), *limits))


def spline_trajectory():
    s = np.linspace(0.0, 1.0, 15)
    path = SplinePath(np.column_stack([np.sin(2 * s), np.cos(3 * s)]))
    return PathTrajectory(path, profile_to_position((0.0, 0.0, 0.0), 1.0, (0.6, 1.5, 20.0)), BOUNDS)


def straight_trajectory():
    profile = profile_to_position((0.0, 0.0, 0.0), 1.0, (1.0, 2.0, 30.0))
    return PathTrajectory(StraightPath(np.zeros(2), np.array([1.0, -0.5])), profile, BOUNDS)


def sequence():
    first = straight_trajectory()
    start = (first.end, np.zeros(2), np.zeros(2))
    return SequenceTrajectory([first, joint_trajectory(start, (0.3, 0.4))])


KINDS = [joint_trajectory, straight_trajectory, spline_trajectory, sequence]


@pytest.fixture(params=KINDS, ids=lambda make: make.__name__)
def trajectory(request):
    return request.param()


def test_velocity_and_acceleration_are_the_derivatives(trajectory):
    h = 1e-5
    middles = np.linspace(0.01, trajectory.duration - 0.01, 97)
    (q0, v0, _), (_, v, a), (q1, v1, _) = (trajectory.sample(middles + d) for d in (-h, 0, h))
    assert np.abs((q1 - q0) / (2 * h) - v).max() < 1e-8 * 100
    inside = np.abs((v1 - v0) / (2 * h) - a)
    assert np.median(inside) < 1e-6 and inside.max() < 100 * h  # the jerk jumps by 100 at most


def test_it_ends_at_rest_exactly_at_its_end(trajectory):
    q, v, a = trajectory.sample(np.array([trajectory.duration, trajectory.duration + 5.0]))
    assert np.array_equal(q, [trajectory.end] * 2)
    assert not v.any() and not a.any()


def test_through_plain_data_it_comes_back_bit_for_bit(trajectory):
    again = trajectory_from_state(json.loads(json.dumps(trajectory.get_state())))
    times = np.linspace(0.0, 1.1 * trajectory.duration, 50)
    for before, after in zip(trajectory.sample(times), again.sample(times), strict=True):
        assert np.array_equal(before, after)


@pytest.mark.parametrize("target", [(1.0, 1.2), (-0.4, 0.1), (0.1, -0.2)])
def test_from_the_middle_of_a_motion_it_goes_on_inside_the_limits(target):
    trajectory = joint_trajectory(MOVING, target)
    for now, then in zip(MOVING, trajectory.sample(np.zeros(1)), strict=True):
        assert np.abs(then[0] - now).max() < 1e-12
    assert limit_use(trajectory, LIMITS).inside


def test_joints_that_are_not_in_step_arrive_together():
    profiles = joint_profiles(MOVING, np.array([1.0, 1.2]), *BOUNDS)
    assert profiles[0].duration == profiles[1].duration


def test_a_long_move_takes_the_time_of_the_textbook():
    # Rest to rest over d with v, a, j all reached: d / v + v / a + a / j.
    profile = profile_to_position((0.0, 0.0, 0.0), 10.0, (2.0, 5.0, 100.0))
    assert profile.duration == pytest.approx(10 / 2 + 2 / 5 + 5 / 100)


def test_braking_takes_the_time_and_the_way_of_the_textbook():
    # From speed v: ramp to a, hold, ramp back: v / a + a / j, over half of it at v.
    profile = profile_to_velocity((1.0, 2.0, 0.0), 0.0, (5.0, 100.0))
    duration = 2 / 5 + 5 / 100
    assert profile.duration == pytest.approx(duration)
    assert profile.end == pytest.approx(1.0 + 2.0 * duration / 2)


def test_slowed_by_two_it_is_the_same_in_twice_the_time():
    profile = profile_to_position((0.0, 0.0, 0.0), 1.0, (1.0, 2.0, 30.0))
    slow = profile.slowed(2.0)
    for t in np.linspace(0.0, profile.duration, 17):
        p, v, a = profile.at(t)
        assert np.allclose(slow.at(2 * t), (p, v / 2, a / 4), atol=1e-12)


def test_a_jump_of_the_position_does_not_pass_for_being_inside_the_limits():
    class Jumping:
        duration, end = 0.1, np.zeros(2)

        def sample(self, times):
            q = np.where(times[:, None] > 0.05, 1.0, 0.0) * ONE
            return q, 0 * q, 0 * q

    assert not limit_use(Jumping(), LIMITS).inside


def test_a_jump_of_the_acceleration_at_the_very_end_is_seen():
    class Stopping:
        duration, end = 0.1, np.zeros(2)

        def sample(self, times):
            a = np.where(times[:, None] < self.duration - 1e-9, 1.0, 0.0) * ONE
            return 0 * a, 0 * a, a

    assert limit_use(Stopping(), LIMITS).jerk == pytest.approx(1000 / 100)
