"""The search for stops on a path."""

import numpy as np
import pytest

from bt_manip.robots import MotionLimits
from bt_manip.trajectories import PathLimits, StraightPath
from bt_manip.trajectories.deceleration_limits import LimitedPath
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


def test_where_the_path_ends_before_a_stop_there_is_none():
    model = pendulum(acceleration=5.0)  # a stop takes 0.1 rad
    assert not list(stop_profiles(straight(model), (0.95, 1.0, 0.0)))
