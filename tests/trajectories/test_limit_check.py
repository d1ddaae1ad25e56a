"""Used fractions of limits."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.robots import JointLimits
from bt_manip.trajectories import (
    JointTrajectory,
    MotionProfile,
    PathLimits,
    TailTrajectory,
    effort_use,
    limit_use,
    tool_use,
)
from bt_manip.trajectories.limit_check import (
    effort_times,
    has_jump,
    motor_efforts,
    sampled_effort_use,
)

from .pendulum import pendulum

ONE = np.ones(2)
LIMITS = JointLimits(-3 * ONE, 3 * ONE, 2 * ONE, 5 * ONE, 100 * ONE, ONE)


class Motion:
    """A motion of 0.1 s whose sample is a function of the times."""

    duration, end = 0.1, np.zeros(2)

    def __init__(self, sample):
        self.sample = lambda times: sample(times[:, np.newaxis])


def test_a_jump_of_the_acceleration_at_the_very_end_counts_as_jerk():
    def stop(t):
        a = np.where(t < 0.1 - 1e-9, 1.0, 0.0) * ONE
        return 0 * a, 0 * a, a

    assert limit_use(Motion(stop), LIMITS).jerk == pytest.approx(1000 / 100)


@pytest.mark.filterwarnings("error")
def test_unlimited_joints_use_no_position_limit():
    endless = np.array([np.inf, 3.0])
    limits = JointLimits(-endless, endless, 2 * ONE, 5 * ONE, 100 * ONE, ONE)
    still = Motion(lambda t: (1.5 + 0 * t * ONE, 0 * t * ONE, 0 * t * ONE))
    assert limit_use(still, limits).position == pytest.approx(0.5)


def test_of_joints_and_other_coordinates_the_one_nearest_each_limit_counts(rng):
    limits = PathLimits(LIMITS, np.array([[0.5], [2.0], [50.0]]))
    for size in ([3, 1, 0.1], [0.1, 3, 1], [0.1, 0.1, 3]):  # of each coordinate
        x, v, a = rng.normal(size=(3, 6, 3)) * size
        steps = np.diff(a, axis=0) / 1e-3
        uses = np.abs(v) / [2, 2, 0.5], np.abs(a) / [5, 5, 2], np.abs(steps) / [100, 100, 50]
        assert limits.use(x, v, a) == pytest.approx([use.max() for use in uses])


def test_efforts_are_those_of_a_pendulum_with_damping_and_dry_friction(rng):
    model = pendulum(gravity=-9.81, effort=7.0, damping=3.0)
    model.friction[:] = 1.5
    q, v, a = rng.normal(size=(3, 5, 1))
    tau = 2.0 * a - 2.0 * 9.81 * np.cos(q) + 3.0 * v + 1.5 * np.sign(v)  # turning lowers it
    np.testing.assert_allclose(motor_efforts(model, q, v, a), tau, atol=1e-9)
    assert tau.max() < -tau.min()
    assert sampled_effort_use(model, q, v, a) == pytest.approx(-tau.min() / 7.0)


def test_efforts_are_known_where_the_jerk_changes_and_also_between_where_that_is_rare():
    # A bar of 2 kg passes the level at 0.35 s; its jerk may change there, or long before and after.
    model = pendulum(gravity=-9.81, effort=30.0)
    for starts in ([0.0], [0.0, 0.1, *np.arange(0.6, 1.0, 0.02)]):
        profile = MotionProfile([[t, t - 0.35, 1.0, 0.0, 0.0] for t in starts], 1.0, 0.65)
        tail = TailTrajectory(JointTrajectory([profile]), 0.1)
        assert effort_use(tail, model) == pytest.approx(2.0 * 9.81 / 30.0, rel=1e-3)
        assert np.diff(effort_times(tail), prepend=0.0).max() < 0.0161
    for step, dense in ((0.031, True), (0.033, False)):
        starts = step * np.arange(20)
        profile = MotionProfile([[t, t, 1.0, 0.0, 0.0] for t in starts], 20 * step, 20 * step)
        trajectory = JointTrajectory([profile])
        assert (len(effort_times(trajectory)) == len(trajectory.breakpoints())) == dense


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_jump_is_more_than_twice_what_the_jerk_explains_in_one_step(rng, side):
    # q = j t^3 / 6 deviates from the trapezoidal rule by j h^3 / 12.
    t, jerk = 1e-3 * np.arange(6)[:, np.newaxis], np.array([50.0, 400.0])
    q, v, a = side * jerk * t**3 / 6.0, side * jerk * t**2 / 2.0, side * jerk * t
    assert not has_jump((q, v, a), jerk)
    for by, jumps in ((0.9, False), (1.1, True), (-2.9, False), (-3.1, True)):
        moved = q + by * side * jerk * 1e-9 / 12.0 * np.outer(np.arange(6) > 3, [0.0, -1.0])
        assert has_jump((moved, v, a), jerk) == jumps


def test_the_speed_of_the_tool_is_found_between_coarse_steps(rng):
    # Speeds of three waves on a ramp, whose maxima are between two steps of 10 ms, or at an end.
    model = pendulum()
    assert tool_use(Motion(lambda t: (t, None, None)), model.limits) == 0.0
    for _ in range(12):
        rate, size, phase = rng.uniform([[10.0], [0.0], [0.0]], [[120.0], [0.15], [6.3]], (3, 3))
        ramp = rng.uniform(-8.0, 8.0)

        def turn(t, rate=rate, size=size, phase=phase, ramp=ramp):
            t = np.minimum(t, 0.1)
            waves = (size / rate * np.cos(rate * t + phase)).sum(axis=1, keepdims=True)
            return 0.2 * t + 0.5 * ramp * t * t - waves, None, None

        for start, share in ((0.043, 0.97), (0.0, 0.97), (0.0, 1.003)):
            times = np.append(np.arange(start, 0.0999, 1e-3), 0.1)[:, np.newaxis]
            chord = 2.0 * np.sin(0.5 * np.abs(np.diff(turn(times)[0], axis=0))).max()  # in 1 ms
            limits = replace(model.limits, tool_speed=share * chord / 1e-3, arm=model)
            use = tool_use(Motion(turn), limits, start)
            assert use == pytest.approx(1.0 / (share * 0.995), rel=1e-6)
        assert tool_use(Motion(turn), limits) == use
        assert tool_use(Motion(turn), limits, 0.2) == 0.0  # after its end
