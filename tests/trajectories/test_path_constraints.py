"""Constraints of a path that turns a pendulum, by hand."""

import numpy as np
import pytest

from bt_manip.trajectories import PathLimits, SplinePath
from bt_manip.trajectories.path_constraints import PathConstraints

from .pendulum import pendulum


def test_constraints_are_those_of_all_coordinates_and_of_the_efforts_with_damping():
    # 2 kg m2 q'' = tau - 7 q' - 1.5 sign(q') + 2 g cos q, upwards first; and a coordinate more.
    model = pendulum(-9.81, effort=40.0, acceleration=30.0, velocity=3.0, damping=7.0)
    model.friction[:] = 1.5
    s = np.linspace(0.0, 1.0, 9)
    q, d1, d2 = 0.8 - 2.0 * s + 1.4 * s * s, 2.8 * s - 2.0, 2.8 + 0.0 * s
    others = np.array([[8.0], [2.0], [50.0]])
    path = SplinePath(np.column_stack([q, 0.5 * s**3]), 1, others)
    limits = PathLimits(model.limits, others)
    constraints = PathConstraints(path, s, limits, model)
    most, gravity = 0.95 * 40.0, -2.0 * 9.81 * np.cos(q)
    left = most - 1.5 - np.sign(d1) * gravity
    speeds = 3.0 / np.abs(d1), 0.9 * left / (7.0 * np.abs(d1)), 8.0 / (1.5 * s * s + 1e-9)
    assert constraints.max_s_dot == pytest.approx(np.min(speeds, axis=0), rel=1e-6)
    assert {*np.argmin(speeds, axis=0)} == {0, 1, 2}
    np.testing.assert_allclose(constraints.a, np.stack([d1, 1.5 * s * s, 2.0 * d1], 1), atol=1e-9)
    np.testing.assert_allclose(constraints.b, np.stack([d2, 3.0 * s, 2.0 * d2], 1), atol=1e-8)
    s_dot = np.linspace(0.2, 1.4, 9)
    lost = gravity + 1.5 * np.sign(d1) + 7.0 * d1 * s_dot
    for bounds, efforts in zip(constraints.bounds(s_dot), (most - lost, most + lost), strict=True):
        expected = np.stack([30.0 + 0.0 * s, 2.0 + 0.0 * s, efforts], 1)
        np.testing.assert_allclose(bounds, expected, atol=1e-8)


@pytest.mark.parametrize(("damping", "damped"), [(0.1, False), (0.11, True)])
def test_damping_matters_from_a_twentieth_of_the_effort_at_the_velocity_limit_on(damping, damped):
    model = pendulum(effort=40.0, velocity=18.0, damping=damping)  # 0.05 * 38 N m at 18 rad/s
    path = SplinePath(np.linspace(0.0, 1.0, 8)[:, np.newaxis])
    limits = PathLimits(model.limits, path.limits)
    constraints = PathConstraints(path, np.linspace(0.0, 1.0, 5), limits, model)
    assert constraints.damped == damped
