"""Paths: values and derivatives at the path parameter s."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from bt_manip.trajectories import SplinePath, StraightPath


@pytest.mark.parametrize("n", [6, 7, 40])
def test_a_spline_is_that_of_scipy(n, rng):
    knots, s = rng.standard_normal((n, 3)), np.linspace(0.0, 1.0, 101)
    expected = make_interp_spline(np.linspace(0.0, 1.0, n), knots, k=5)
    path = SplinePath(knots, nq=2)
    for order, values in enumerate(path.evaluate(s)):
        assert np.abs(values - expected(s, order)).max() < 1e-11 * n**order
    assert np.array_equal(path.end, knots[-1, :2])
    assert np.array_equal(path.limits, np.full((3, 1), np.inf))


def test_a_spline_through_too_few_knots_is_refused():
    with pytest.raises(ValueError):
        SplinePath(np.zeros((5, 1)))


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_straight_path_gives_as_many_derivatives_as_are_requested(order):
    path = StraightPath(np.array([1.0, 2.0]), np.array([2.0, 0.0]))
    expected = ([1.5, 1.0], [1.0, -2.0], [0.0, 0.0])[: order + 1]
    assert np.array_equal(np.squeeze(path.evaluate(np.array([0.5]), order)), np.squeeze(expected))
