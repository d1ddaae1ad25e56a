"""Changes of the speed scale of a joint that turns at constant velocity, known by hand."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.trajectories import JointTrajectory, MotionProfile, at_speed_scale
from bt_manip.trajectories.time_scaling import change_speed_scale

from .pendulum import pendulum

TURNING = JointTrajectory([MotionProfile([[0.0, 0.0, 1.0, 0.0, 0.0]], 2.0, 2.0)])  # 1 rad/s


@pytest.mark.parametrize(
    ("now", "s_ddot", "new"),
    [(1.0, 0.0, 0.2), (0.2, 0.0, 1.0), (1.0, 0.0, 0.5), (0.5, 2.0, 0.5), (0.4, -3.0, 0.9)],
)
def test_the_speed_changes_in_the_time_of_the_textbook_and_the_end_is_reached_then(
    now, s_ddot, new
):
    # 4 rad/s2, whatever the jerk: |v1 - v0| / a, and 10 ms to smooth it.
    model = pendulum(acceleration=4.0, effort=1e4, jerk=1e4)
    change = change_speed_scale(TURNING, (1.5, now, s_ddot), new, model)
    assert change is not None and change.near_optimal
    t = np.linspace(0.0, change.trajectory.duration, 20001)[:-1]
    s, s_dot, u = change.trajectory.time_scaling.sample(t)
    shortest = abs(new - now) / 4.0
    assert u[0] == s_ddot and t[np.abs(u) > 1e-6].max() == pytest.approx(
        shortest, rel=0.05, abs=0.02
    )
    assert s_dot[0] == pytest.approx(now) and s_dot[-1] == pytest.approx(new)
    assert s[0] == 1.5 and s[-1] == pytest.approx(2.0, abs=1e-3)
    assert np.gradient(s, t)[1:-1] == pytest.approx(s_dot[1:-1], abs=1e-4)
    assert np.diff(s_dot) == pytest.approx(np.diff(t) * (u[1:] + u[:-1]) / 2.0, abs=2e-6)
    driven = np.diff(t) @ (s_dot[1:] + s_dot[:-1]) / 2.0
    assert driven == pytest.approx(2.0 - 1.5, rel=1e-3)


@pytest.mark.parametrize(("acceleration", "effort"), [(5.0, 1e4), (1e3, 30.0)])
@pytest.mark.parametrize(
    ("now", "new", "side"), [(0.9, 0.2, 1.0), (0.2, 0.9, 1.0), (0.2, 0.9, -1.0)]
)
def test_while_the_speed_changes_a_limit_is_in_use_at_all_times(
    now, new, side, acceleration, effort
):
    # The bar of 2 kg turns under gravity, faster and then slower: t is the nominal time.
    model = pendulum(-9.81, effort, acceleration, damping=2.0)
    model.friction[:] = 1.5
    profile = MotionProfile([[0.0, -1.0, 1.2, 3.0, -9.0]], 0.8, 0.152)
    nominal = JointTrajectory([profile.scaled(side, side * profile.end)])
    change = change_speed_scale(nominal, (0.1, now, 0.0), new, model)
    times = np.arange(0.0, change.trajectory.duration, 1e-3)
    s, _, s_ddot = change.trajectory.time_scaling.sample(times)
    q, _, a = (rows[:, 0] for rows in change.trajectory.sample(times))
    free = 0.95 * effort - 1.5 - 2.0 * np.abs(nominal.sample(s)[1][:, 0])
    use = np.maximum(np.abs(a) / acceleration, np.abs(2.0 * a - 2.0 * 9.81 * np.cos(q)) / free)
    changing = np.flatnonzero(np.abs(s_ddot) > 1e-6)
    middle = use[len(changing) // 4 : len(changing) * 3 // 4]
    assert change.near_optimal and 0.94 < middle.min() and middle.max() < 1.025


@pytest.mark.parametrize(
    ("jerk", "time"), [(900, 0.1), (240, 0.2), (60, 0.4), (15, 0.8), (4, 1.6), (1, 3.2)]
)
def test_a_rise_from_rest_that_only_the_jerk_limits_keeps_it_and_takes_not_twice_as_long(
    jerk, time
):
    model = pendulum(acceleration=1e3, effort=1e4, jerk=jerk)
    change = change_speed_scale(TURNING, (0.1, 0.0, 0.0), 1.0, model)
    t = np.arange(0.0, change.trajectory.duration, 1e-3)
    s_ddot = change.trajectory.time_scaling.sample(t)[2]
    assert np.abs(np.diff(s_ddot)).max() <= 1e-3 * jerk
    # Twice the mean acceleration is reached in a quarter of the time, held for as long, and left.
    assert s_ddot.max() == pytest.approx(2.0 / time)
    last = t[np.abs(s_ddot) > 1e-6].max()
    assert last == pytest.approx(0.75 * time, abs=2e-3) and last + 2e-3 < 4.0 * np.sqrt(1.0 / jerk)
    assert not change.near_optimal


@pytest.mark.parametrize(
    ("jerk", "share"),
    [(450, 0.995), (385, 0.97), (340, 0.9), (280, 0.8), (180, 0.6), (90, 0.4), (30, 0.2)],
)
def test_the_largest_share_of_the_acceleration_is_used_that_keeps_the_jerk(jerk, share):
    model = pendulum(acceleration=4.0, effort=1e4, jerk=jerk)
    for now, new in ((1.0, 0.8), (0.8, 1.0)):
        change = change_speed_scale(TURNING, (0.1, now, 0.0), new, model)
        s_ddot = change.trajectory.time_scaling.sample(np.arange(0.0, 0.5, 1e-3))[2]
        assert np.abs(s_ddot).max() == pytest.approx(4.0 * share**2, rel=0.02)
        assert change.near_optimal == (share >= 0.8)


def test_a_change_may_use_as_much_effort_as_the_motion_and_stays_where_that_is():
    # Level at first, the bar needs 97 % of the effort, at a position beyond the limit of 10 rad.
    model, q = pendulum(-9.81, effort=2.0 * 9.81 / 0.97), 4.0 * np.pi
    nominal = JointTrajectory([MotionProfile([[0.0, q, 1.0, 0.0, 0.0]], 2.0, q + 2.0)])
    assert change_speed_scale(nominal, (0.1, 0.5, 0.0), 1.0, model) is not None


def test_where_the_speed_of_the_tool_is_limited_the_scale_does_not_overshoot():
    model = pendulum(acceleration=4.0, effort=1e4, jerk=1e4)
    assert change_speed_scale(TURNING, (0.5, 0.5, 2.0), 0.5, model) is not None
    model.limits = replace(model.limits, tool_speed=30.0, arm=model)
    assert change_speed_scale(TURNING, (0.5, 0.5, 2.0), 0.5, model) is None
    assert change_speed_scale(TURNING, (0.5, 1.0, 0.0), 0.5, model) is not None


def test_at_a_constant_scale_the_rest_takes_its_time_and_at_none_it_stays():
    rest = at_speed_scale(TURNING, 0.5, 0.25)
    assert rest.duration == pytest.approx((2.0 - 0.5) / 0.25)
    q, v, a = rest.sample(np.array([0.0, 2.0, 6.0]))
    assert np.allclose(q[:, 0], [0.5, 1.0, 2.0]) and np.allclose(v[:2], 0.25) and not a.any()
    still = at_speed_scale(TURNING, 0.5, 0.0)
    assert still.duration == 0.0 and still.end == pytest.approx([0.5])
    model = pendulum(effort=1e4)
    assert change_speed_scale(TURNING, (2.0, 1.0, 0.0), 0.5, model) is None
    with pytest.raises(MotionError, match="would take 1.5e"):
        change_speed_scale(TURNING, (0.5, 1.0, 0.0), 1e-3, model)
