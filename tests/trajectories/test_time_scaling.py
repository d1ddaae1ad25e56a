"""Changes of the speed scale of a joint that turns at constant velocity, known by hand."""

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.trajectories import JointTrajectory, MotionProfile, at_speed_scale
from bt_manip.trajectories.time_scaling import change_speed_scale

from .pendulum import pendulum

TURNING = JointTrajectory([MotionProfile([[0.0, 0.0, 1.0, 0.0, 0.0]], 2.0, 2.0)])  # 1 rad/s


@pytest.mark.parametrize(("now", "new"), [(1.0, 0.2), (0.2, 1.0), (1.0, 0.5)])
def test_the_speed_changes_in_the_time_of_the_textbook_and_the_end_is_reached_then(now, new):
    # 4 rad/s2, whatever the jerk: |v1 - v0| / a, and 10 ms to smooth it.
    model = pendulum(acceleration=4.0, effort=1e4, jerk=1e4)
    change = change_speed_scale(TURNING, (1.5, now, 0.0), new, model)
    assert change is not None and change.near_optimal
    t = np.linspace(0.0, change.trajectory.duration, 20001)[:-1]
    s, s_dot, s_ddot = change.trajectory.time_scaling.sample(t)
    shortest = abs(new - now) / 4.0
    assert t[np.abs(s_ddot) > 1e-6].max() == pytest.approx(shortest, rel=0.05, abs=0.02)
    assert s_dot[0] == pytest.approx(now) and s_dot[-1] == pytest.approx(new)
    assert s[0] == 1.5 and s[-1] == pytest.approx(2.0, abs=1e-3)
    assert np.gradient(s, t)[1:-1] == pytest.approx(s_dot[1:-1], abs=1e-4)
    driven = np.diff(t) @ (s_dot[1:] + s_dot[:-1]) / 2.0
    assert driven == pytest.approx(2.0 - 1.5, rel=1e-3)


def test_damping_leaves_less_effort_for_a_change_of_the_speed():
    # 95 % of the effort, less the damping at 1 rad/s, turn 2 kg m2 by 4 rad/s2.
    model = pendulum(acceleration=1e3, effort=(2.0 * 4.0 + 5.0) / 0.95, damping=5.0, jerk=1e4)
    change = change_speed_scale(TURNING, (1.0, 0.2, 0.0), 1.0, model)
    t = np.linspace(0.0, 0.5, 5001)
    s_ddot = change.trajectory.time_scaling.sample(t)[2]
    assert change.near_optimal and np.abs(s_ddot).max() == pytest.approx(4.0, rel=0.01)


@pytest.mark.parametrize("jerk", [240.0, 60.0, 15.0, 4.0, 1.0])
def test_a_rise_from_rest_that_only_the_jerk_limits_keeps_it_and_takes_not_twice_as_long(jerk):
    model = pendulum(acceleration=1e3, effort=1e4, jerk=jerk)
    change = change_speed_scale(TURNING, (0.1, 0.0, 0.0), 1.0, model)
    t = np.arange(0.0, change.trajectory.duration, 1e-3)
    s_ddot = change.trajectory.time_scaling.sample(t)[2]
    assert np.abs(np.diff(s_ddot)).max() <= 1e-3 * jerk
    shortest = 2.0 * np.sqrt(1.0 / jerk)  # of the jerk up, and down again
    assert shortest <= t[np.abs(s_ddot) > 1e-6].max() + 2e-3 < 2.0 * shortest
    assert not change.near_optimal


def test_at_a_constant_scale_the_rest_takes_its_time_and_at_none_it_stays():
    rest = at_speed_scale(TURNING, 0.5, 0.25)
    assert rest.duration == pytest.approx((2.0 - 0.5) / 0.25)
    q, v, a = rest.sample(np.array([0.0, 2.0, 6.0]))
    assert np.allclose(q[:, 0], [0.5, 1.0, 2.0]) and np.allclose(v[:2], 0.25) and not a.any()
    still = at_speed_scale(TURNING, 0.5, 0.0)
    assert still.duration == 0.0 and still.end == pytest.approx([0.5])
    model = pendulum(effort=1e4)
    change = change_speed_scale(TURNING, (0.5, 0.5, 2.0), 0.5, model)  # it is changing now
    assert change.trajectory.time_scaling.at(0.0) == pytest.approx((0.5, 0.5, 2.0))
    assert change_speed_scale(TURNING, (2.0, 1.0, 0.0), 0.5, model) is None
    with pytest.raises(MotionError, match="would take 1.5e"):
        change_speed_scale(TURNING, (0.5, 1.0, 0.0), 1e-3, model)
