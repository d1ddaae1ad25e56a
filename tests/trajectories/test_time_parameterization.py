"""Trajectories of a pendulum, known by hand, and of the Panda."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.trajectories import (
    SplinePath,
    StraightPath,
    effort_use,
    scale_to_effort_limits,
    time_parameterize,
    time_parameterize_segment,
)
from tests.measuring.time_optimal_duration import time_optimal_duration

from .pendulum import pendulum
from .test_topp import bent


def test_friction_counts_in_the_direction_of_the_motion():
    model = pendulum(gravity=-9.81, effort=19.0)  # 18.05 N m are allowed
    model.friction[:] = 2.0
    # The bar is level at 0. At 0.5 gravity needs 17.2 N m, and friction adds to it on the way up.
    high, low = np.array([0.5]), np.array([1.0])
    assert effort_use(time_parameterize_segment(high, low, model), model) <= 0.9501
    parts = "joint 1 needs 19.2. N m .*, 17.22 N m for gravity and 2 N m for friction; 18.05 N m"
    with pytest.raises(MotionError, match=parts) as raised:
        time_parameterize_segment(low, high, model)
    assert raised.value.reason == "effort"


def test_with_scarce_jerk_and_effort_it_is_nearly_as_fast_as_both_allow():
    # 32 N m turn 2 kg m2 by 16 rad/s2, which take r = 16 / 500 s to come and to go: half the path
    # is a (t - r) t / 2 in the time t. A profile that is slowed for its jerk needs less effort.
    model = pendulum(effort=32.0 / 0.95, acceleration=20.0, jerk=500.0)
    path = StraightPath(np.zeros(1), 5.0 * np.ones(1))
    duration = time_parameterize(path, model).duration
    a, r = 16.0, 16.0 / 500.0
    optimum = r + np.sqrt(r**2 + 4 * 5.0 / a)
    assert optimum < duration < 1.045 * optimum


@pytest.mark.parametrize("end", [0.2, 3.0])  # in less and in more than a second
def test_where_nothing_bends_the_first_grid_serves(end):
    model, tried = pendulum(effort=1e4, acceleration=5.0, jerk=500.0), []
    grids = (tried.append(grid) or grid for grid in (120, 360))
    time_parameterize(StraightPath(np.zeros(1), np.array([end])), model, grids=grids)
    assert tried == [120]


def test_a_curved_path_is_followed_inside_all_limits_and_close_to_one(model, rng):
    for _ in range(5):
        a, b, c = rng.uniform(0.7 * model.limits.lower, 0.7 * model.limits.upper, (3, 7))
        s = np.linspace(0.0, 1.0, 15)[:, np.newaxis]
        path = SplinePath(a * (1 - s) ** 2 + 2 * b * s * (1 - s) + c * s**2)
        trajectory = time_parameterize(path, model)
        use, effort = trajectory.kinematic_use(model.limits), effort_use(trajectory, model)
        assert max(use) <= 1.0 and effort <= 0.9501
        # Something binds: a velocity, an acceleration or an effort.
        assert max(use[0], use[1], effort / 0.95) > 0.998


@pytest.mark.parametrize(("jerk", "longer"), [(1.0, 1.017), (0.05, 1.107)])
def test_a_tight_corner_does_not_slow_the_rest_of_a_path(model, jerk, longer):
    pytest.importorskip("toppra")
    model = model.copy()
    model.limits = replace(model.limits, jerk=jerk * model.limits.jerk)
    tried = []
    grids = (tried.append(grid) or grid for grid in (120, 360))
    trajectory = time_parameterize(bent(model, 5), model, grids=grids)
    assert max(trajectory.kinematic_use(model.limits)) <= 1.0 and tried == [120, 360]
    assert trajectory.duration <= longer * time_optimal_duration(trajectory, model)


@pytest.mark.parametrize(
    ("tool_speed", "speed"), [(0.5, 1.0), (0.5, 0.5), (2.1, 1.0), (30.0, 1.0), (30.0, 0.4)]
)
def test_a_slow_tool_takes_the_time_of_the_textbook(tool_speed, speed):
    # d / v + v / a + a / j; the tool of the bar of 1 m uses 99.5 % of its speed.
    model = pendulum(acceleration=5.0, jerk=500.0, effort=1e3)
    model.limits = replace(model.limits, tool_speed=tool_speed, arm=model)
    start, end = np.array([-0.7]), np.array([0.5])
    a, j = 5.0 * speed**2, 500.0 * speed**3
    v = min(0.995 * tool_speed, np.sqrt(1.2 * a + (0.5 * a * a / j) ** 2) - 0.5 * a * a / j)
    for trajectory in (
        time_parameterize_segment(start, end, model, speed),
        time_parameterize(StraightPath(start, end), model, speed),
    ):
        assert trajectory.duration == pytest.approx(1.2 / v + v / a + a / j, rel=0.015)
        q = trajectory.sample(np.arange(0.0, trajectory.duration, 1e-3))[0]
        assert np.abs(np.diff(q, axis=0)).max() <= 0.995e-3 * tool_speed + 1e-9


def test_the_greatest_scale_inside_the_effort_limits_is_found():
    model, strong = pendulum(effort=10.0), pendulum(effort=1e4)  # 9.5 N m turn it by 4.75 rad/s2
    factors = []

    def plan(factor):
        factors.append(factor)
        strong.limits = replace(strong.limits, acceleration=np.array([20.0 * factor]))
        return time_parameterize_segment(np.zeros(1), np.ones(1), strong)

    found = scale_to_effort_limits(plan, model)
    assert 0.97 * 0.95 <= effort_use(found, model) <= 0.95
    assert len(factors) < 12 and factors[:2] == [1.0, 0.7]
    factors.clear()
    scale_to_effort_limits(plan, pendulum(effort=1e3))
    assert factors == [1.0]  # inside the limits it keeps all its accelerations
    heavy = pendulum(gravity=-9.81, effort=15.0)
    with pytest.raises(MotionError, match="needs 131 % of an effort limit even when slow; 95 %"):
        scale_to_effort_limits(plan, heavy)
