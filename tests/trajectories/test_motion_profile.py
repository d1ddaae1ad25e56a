"""Motion profiles with the durations and distances of the textbook."""

from itertools import pairwise

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.trajectories.motion_profile import (
    MotionProfile,
    integrate_acceleration,
    joint_profiles,
    profile_to_position,
    profile_to_velocity,
    velocity_profiles,
)

LIMITS = (2 * np.ones(2), 5 * np.ones(2), 100 * np.ones(2))  # velocity, acceleration, jerk
MOVING = (np.array([0.1, -0.2]), np.array([1.5, -0.5]), np.array([2.0, -4.0]))


def test_joints_that_move_by_different_distances_arrive_together():
    profiles = joint_profiles(MOVING, np.array([1.0, 1.2]), *LIMITS)
    assert profiles[0].duration == profiles[1].duration
    target, final = np.array([1.0, 1.3]), (np.array([0.7, -0.3]), np.array([1.0, 2.0]))
    profiles = joint_profiles(MOVING, target, *LIMITS, final, 4.0)
    for i, profile in enumerate(profiles):
        assert profile.duration == pytest.approx(4.0)  # longer than it needs
        assert profile.at(0.0) == pytest.approx([rows[i] for rows in MOVING])
        assert profile.at(profile.duration - 1e-9) == pytest.approx(
            [target[i], *(rows[i] for rows in final)], abs=1e-6
        )
        assert profile.at(4.1) == (target[i], 0.0, 0.0)
        t = np.linspace(0.0, 3.999, 40001)
        rows = profile.sample(t)
        for values, rates in pairwise(rows):
            assert np.allclose(np.gradient(values, t)[1:-1], rates[1:-1], atol=0.01)
        np.testing.assert_allclose(
            np.array([profile.at(x) for x in t[::900]]).T, np.array(rows)[:, ::900], atol=1e-12
        )


def test_braking_takes_the_time_and_the_distance_of_the_textbook():
    # From speed v: ramp to a, hold, ramp back: v / a + a / j, over half of it at v.
    profile = profile_to_velocity((1.0, 2.0, 0.0), 0.0, (5.0, 100.0))
    duration = 2 / 5 + 5 / 100
    assert profile.duration == pytest.approx(duration)
    assert profile.end == pytest.approx(1.0 + 2.0 * duration / 2)


def test_velocities_are_reached_after_the_duration_and_then_rest_as_soon_as_possible():
    # Linear in jerk: half the final velocity on average, whether it rises or falls.
    rest, velocity = np.zeros(3), np.array([1.0, -0.5, 0.0])
    profiles = velocity_profiles(
        (np.array([0.3, -0.3, 0.9]), rest, rest), velocity, 2.0, 5 * np.ones(3), 100 * np.ones(3)
    )
    stop = 1.0 / 5 + 5 / 100
    for profile, begin, v in zip(profiles, (0.3, -0.3, 0.9), velocity, strict=True):
        assert profile.duration == pytest.approx(2.0 + stop)
        assert profile.at(2.0)[1] == pytest.approx(v)
        assert profile.end == pytest.approx(begin + v * (2.0 + stop) / 2.0)
        t = np.linspace(0.0, profile.duration, 5001)
        p, rate, _ = profile.sample(t[:-1])
        assert np.allclose(np.gradient(p, t[:-1])[1:-1], rate[1:-1], atol=1e-4)


def test_slowed_by_two_it_is_the_same_in_twice_the_time():
    profile = profile_to_position((0.0, 0.0, 0.0), 1.0, (1.0, 2.0, 30.0))
    slow = profile.slowed(2.0)
    for t in np.linspace(0.0, profile.duration, 17):
        p, v, a = profile.at(t)
        assert np.allclose(slow.at(2 * t), (p, v / 2, a / 4), atol=1e-12)
        assert np.allclose(profile.scaled(-3.0, -3.0).at(t), (-3 * p, -3 * v, -3 * a), atol=1e-12)
    twice = profile.then(MotionProfile([[0.0, 1.0, 0.0, 0.0, 6.0]], 0.5, 1.125))
    assert twice.duration == profile.duration + 0.5 and twice.end == 1.125
    assert twice.breakpoints()[-2:] == pytest.approx([profile.duration, twice.duration])
    assert twice.at(profile.duration + 0.1) == pytest.approx((1.001, 0.03, 0.6))
    before = [profile.at(-1e-3)[0], *profile.sample(np.full(1, -1e-3))[0]]
    assert before == pytest.approx([0.0, 0.0], abs=1e-7)
    assert MotionProfile([], 2.0, 0.7).at(1.5) == (0.7, 0.0, 0.0)  # it stays
    assert slow.slowed(600.0 / slow.duration).duration == pytest.approx(600.0)
    with pytest.raises(MotionError, match="would take 601 s .*; at most 600 s"):
        slow.slowed(601.0 / slow.duration)


def test_a_linear_acceleration_is_integrated_exactly():
    t = np.array([0.0, 0.5, 2.0])
    rows = integrate_acceleration((1.0, 2.0, 0.0), t, 3.0 + 6.0 * t)
    assert np.allclose(rows[:, 1], 1.0 + 2.0 * t + 1.5 * t**2 + t**3)
    assert np.allclose(rows[:, 2], 2.0 + 3.0 * t + 3.0 * t**2)
    assert np.allclose(rows[:, 4], [6.0, 6.0, 0.0])
