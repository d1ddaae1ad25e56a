"""Time-optimal profiles of a pendulum, known by hand, and of the Panda."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.trajectories import PathLimits, PathTrajectory, SplinePath, StraightPath, sample_times
from bt_manip.trajectories.limit_check import sampled_effort_use
from bt_manip.trajectories.topp import TimeOptimalParameterization

from .pendulum import pendulum


def timed(model, start=0.0, end=1.0):
    path = StraightPath([start], [end])
    topp = parameterization(path, model, model)
    return PathTrajectory(path, topp.profile(topp.smoothing_steps[0]))


def parameterization(path, model, loads):
    limits = PathLimits(model.limits, path.limits)
    return TimeOptimalParameterization(path, limits, loads, 120)


@pytest.mark.parametrize(
    ("limits", "end", "duration"),
    [
        # Half the distance at a, half at -a: 2 sqrt(d / a).
        ({"effort": 1e4, "acceleration": 4.0}, 1.5, 2 * np.sqrt(1.5 / 4.0)),
        # 95 % of 10 N m turn 2 kg m2 by 4.75 rad/s2.
        ({"effort": 10.0}, 1.5, 2 * np.sqrt(1.5 / 4.75)),
        # v(t) = 1.9 (1 - exp(-2.5 t)), up to 90 % of it; it cruises, and brakes in 0.257 s.
        ({"effort": 10.0, "damping": 5.0}, 1.5, 1.317),
        # It cruises: d / v + v / a.
        ({"effort": 1e4, "acceleration": 4.0, "velocity": 1.0}, 3.0, 3.0 / 1.0 + 1.0 / 4.0),
    ],
    ids=["acceleration", "effort", "damping", "velocity"],
)
def test_the_duration_under_one_limit_is_that_of_the_textbook(limits, end, duration):
    plan = timed(pendulum(**limits), end=end)
    assert plan.duration == pytest.approx(duration, rel=0.024)
    # Its segments, at most about 250, lead from one to the next, and the last one to rest.
    profile, times = plan.profile, plan.profile.breakpoints()[1:]
    before = np.array([profile.at(t - 1e-12) for t in times])
    after = np.array([profile.at(t) for t in times])
    np.testing.assert_allclose(before, after, rtol=0.0, atol=1e-8)
    assert profile.end == 1.0 and len(times) <= 252


def test_a_load_that_changes_between_grid_points_does_not_exceed_the_effort_limit():
    # 5.1 rad in 120 steps: in each, gravity changes by up to 0.8 N m, 3 % of the effort.
    model = pendulum(gravity=-9.81, effort=25.0, acceleration=20.0)
    plan = timed(model, -5.0, 0.1)
    fine = plan.sample(sample_times(plan.duration, 1e-3))
    assert 0.9 < sampled_effort_use(model, *fine) <= 0.951


def bent(model, sharpness):
    """Return two segments with a corner that is rounded within a few of 144 steps."""
    first = np.array([2.25, 0.0, 0.75, 0.0, 1.2, 0.0, 0.75]) / 144
    second = np.array([0.0, 1.2, -0.45, 1.2, 0.0, 1.35, -1.2]) / 144
    steps = np.where(np.arange(144)[:, np.newaxis] < 58, first, second)
    window = np.hanning(sharpness) / np.hanning(sharpness).sum()
    half = sharpness // 2
    steps[half:-half] = [window @ steps[k : k + sharpness] for k in range(145 - sharpness)]
    return SplinePath(model.home + np.vstack([np.zeros(7), np.cumsum(steps, axis=0)]))


@pytest.mark.parametrize(
    ("order", "jerk", "exceeded", "left", "slower"),
    [(1, 1.0, 1.5, 1.195, (1.01, 1.02)), (2, 0.05, 2.0, 1.165, (1.03, 1.045))],
    ids=["acceleration", "jerk"],
)
def test_tightening_slows_a_profile_only_where_it_exceeded_a_limit(
    model, order, jerk, exceeded, left, slower
):
    model = model.copy()
    model.limits = replace(model.limits, jerk=jerk * model.limits.jerk)
    path = bent(model, 5)
    topp = parameterization(path, model, None)
    node = topp.smoothing_steps[0]
    plan = topp.profile(node)
    again = topp.tightened(plan).profile(node)
    first, second = (
        PathTrajectory(path, profile).kinematic_use(model.limits)[order]
        for profile in (plan, again)
    )
    assert first > exceeded and second < left
    assert slower[0] * plan.duration < again.duration < slower[1] * plan.duration
    behind = np.linspace(0.6, 0.98, 30)  # the corner is at 0.4
    speeds = (
        np.interp(behind, *profile.sample(np.arange(0.0, profile.duration, 1e-3))[:2])
        for profile in (again, plan)
    )
    assert order == 2 or np.allclose(*speeds, rtol=0.01)
