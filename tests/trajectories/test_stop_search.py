"""The search for stops on a path."""

import numpy as np
import pytest

from bt_manip.robots import MotionLimits
from bt_manip.trajectories import PathLimits, StraightPath
from bt_manip.trajectories.deceleration_limits import LimitedPath
from bt_manip.trajectories.motion_profile import profile_to_velocity
from bt_manip.trajectories.stop_search import STOP_MARGINS, shortest_stop_time, stop_profiles

from .pendulum import pendulum

MOVING = (0.0, 1.0, 0.0)  # s, s_dot, s_ddot


def straight(model):
    path = StraightPath(np.zeros(1), np.ones(1))
    return LimitedPath(path.evaluate, PathLimits(model.limits, path.limits), 1.0)


def test_the_shortest_time_to_stop_is_that_of_the_textbook():
    # v / a to brake, and a / j for the acceleration to come and to go.
    one = np.ones(2)
    limits = MotionLimits(-one, one, one, np.array([4.0, 5.0]), 100.0 * one, one)
    shortest = shortest_stop_time(
        np.array([2.0, -1.0]), np.zeros(2), PathLimits(limits, np.empty((3, 0)))
    )
    assert shortest == pytest.approx(2.0 / 4.0 + 4.0 / 100.0)


def test_no_coordinate_stops_faster_than_ruckig_stops_it():
    rng, one = np.random.default_rng(4), np.ones(1)
    for _ in range(50):
        bound, jerk = rng.uniform(1.0, 20.0), rng.uniform(50.0, 5000.0)
        v = rng.uniform(-2.0, 2.0) * 10.0 ** rng.uniform(-3.0, 0.0)
        a = rng.uniform(-bound, bound)
        limits = MotionLimits(-one, one, 9 * one, bound * one, jerk * one, one)
        shortest = shortest_stop_time(
            np.array([v]), np.array([a]), PathLimits(limits, np.empty((3, 0)))
        )
        ruckig = profile_to_velocity((0.0, v, a), 0.0, (bound, jerk)).duration
        assert shortest == pytest.approx(ruckig, rel=1e-6, abs=1e-9)


def test_effort_limits_of_a_weak_motor_determine_the_stop():
    # 98 % of 10 N m turn 2 kg m2 by 4.9 rad/s2, whatever the joint's own limits are.
    weak = pendulum(effort=10.0)
    profile = next(stop_profiles(straight(weak), MOVING, weak))
    assert profile.duration == pytest.approx(1.0 / 4.9, rel=0.03)


def test_a_search_evaluates_a_bounded_number_of_profiles():
    model = pendulum(acceleration=5.0, jerk=500.0)
    profiles = list(stop_profiles(straight(model), MOVING))
    assert 0 < len(profiles) <= len(STOP_MARGINS)
    for profile in profiles:
        s, s_dot, s_ddot = profile.sample(np.linspace(0.0, profile.duration - 1e-6, 200))
        assert np.all(np.diff(s) >= 0.0) and s[-1] <= 1.0
        assert s_dot.min() >= -1e-9 and s_ddot.min() >= -5.0 * (1.0 + 1e-6)


@pytest.mark.parametrize(("speed", "steps"), [(0.005, 10), (0.05, 100), (1.0, 200), (9.0, 250)])
def test_a_stop_has_enough_steps_for_its_shape_but_a_bounded_number(speed, steps):
    model = pendulum(acceleration=5.0, jerk=5e4, velocity=10.0)
    path = StraightPath(np.zeros(1), 20.0 * np.ones(1))
    limited = LimitedPath(path.evaluate, PathLimits(model.limits, path.limits), 1.0)
    profile = next(stop_profiles(limited, (0.0, speed / 20.0, 0.0)))
    assert steps <= len(profile.segments) <= steps + 5
    exact = speed / 5.0 + 1e-4  # v / a + a / j
    assert profile.duration == pytest.approx(exact, rel=0.015)


def test_where_the_path_ends_before_a_stop_there_is_none():
    model = pendulum(acceleration=5.0)  # a stop takes 0.1 rad
    assert not list(stop_profiles(straight(model), (0.95, 1.0, 0.0)))


@pytest.mark.parametrize(("bend", "jerk"), [(0.0, 500.0), (0.3, 50.0), (-0.3, 500.0)])
def test_a_joint_stops_as_fast_as_ruckig_however_its_path_is_parameterized(bend, jerk):
    # q = s + b s^2: where the path parameter's own jerk is zero, the joint's is not.
    model = pendulum(acceleration=5.0, effort=1e4, jerk=jerk)

    def evaluate(s):
        s = s[:, np.newaxis]
        return s + bend * s * s, 1.0 + 2.0 * bend * s, 2.0 * bend * np.ones_like(s)

    path = LimitedPath(evaluate, PathLimits(model.limits, np.empty((3, 0))), 1.0)
    keeping = [
        (profile.duration, q, v, a)
        for profile in stop_profiles(path, MOVING)
        for q, v, a in [path.sample(profile, np.arange(0.0, profile.duration, 1e-3))]
        if np.abs(a).max() <= 5.0 and np.abs(np.diff(a[:, 0])).max() <= 1e-3 * jerk
    ]
    duration, q, v, _ = keeping[0]
    fastest = profile_to_velocity((0.0, 1.0, 2.0 * bend), 0.0, (5.0, jerk)).duration
    assert fastest <= duration * (1.0 + 1e-3) and duration <= 1.05 * fastest
    assert np.gradient(q[:, 0], 1e-3)[1:-1] == pytest.approx(v[1:-1, 0], abs=1e-4)


def test_where_no_path_jerk_suits_both_joints_a_stop_inside_all_limits_is_found():
    # The second joint bends while the first, whose jerk is scarce, turns evenly: braking changes
    # the second's acceleration faster than its own limit allows, unless the path jerk counters it.
    one = np.ones(2)
    limits = MotionLimits(-9 * one, 9 * one, 9 * one, 5 * one, np.array([8.0, 20.0]), one)

    def evaluate(s):
        s, even = s[:, np.newaxis], np.ones((len(s), 1))
        first, second = (s, even, 0.0 * even), (s + 2.0 * s * s, 1.0 + 4.0 * s, 4.0 * even)
        return [np.hstack(columns) for columns in zip(first, second, strict=True)]

    path = LimitedPath(evaluate, PathLimits(limits, np.empty((3, 0))), 1.0)
    fastest = shortest_stop_time(one, np.array([0.0, 4.0]), path.limits)
    inside = [
        profile.duration
        for profile in stop_profiles(path, MOVING)
        if max(path.limits.use(*path.sample(profile, np.arange(0.0, profile.duration, 1e-3)))) <= 1
    ]
    assert fastest <= inside[0] <= 1.2 * fastest
