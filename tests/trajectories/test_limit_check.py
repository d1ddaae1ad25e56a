"""Used fractions of limits."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.robots import JointLimits
from bt_manip.trajectories import (
    PathLimits,
    limit_use,
    tool_use,
)
from bt_manip.trajectories.limit_check import motor_efforts, sampled_effort_use

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


def test_the_speed_of_the_tool_is_found_between_coarse_steps():
    # q' = 0.2 + 0.1 sin(70 t) rad/s, whose maxima are between two steps of 10 ms.
    model = pendulum()
    limits = replace(model.limits, tool_speed=0.3, arm=model)
    motion = Motion(lambda t: (0.2 * t - 0.1 / 70.0 * np.cos(70.0 * np.minimum(t, 0.1)),))
    for start, most in ((0.0, 0.29998), (0.03, 0.284484)):  # at first, or just after the start
        assert tool_use(motion, limits, start) == pytest.approx(most / (0.995 * 0.3), rel=1e-4)
    assert tool_use(motion, model.limits) == 0.0
