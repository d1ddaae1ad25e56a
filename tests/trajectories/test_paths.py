"""Paths: values and derivatives at the path parameter s."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from bt_manip.trajectories import SplinePath, StraightPath


def test_a_quintic_spline_reproduces_a_quintic_polynomial():
    s = np.linspace(0.0, 1.0, 9)
    coefficients = np.array([3.0, -1.0, 2.0, 0.5, -4.0, 1.0])
    path = SplinePath(np.polyval(coefficients, s)[:, None])
    x = np.linspace(0.0, 1.0, 50)
    for order, values in enumerate(path.evaluate(x)):
        expected = np.polyval(np.polyder(coefficients, order), x)
        assert np.abs(values[:, 0] - expected).max() < 1e-8 * 10**order


@pytest.mark.parametrize("n", [6, 7, 40])
def test_a_spline_is_that_of_scipy(n, rng):
    knots, s = rng.standard_normal((n, 3)), np.linspace(0.0, 1.0, 101)
    expected = make_interp_spline(np.linspace(0.0, 1.0, n), knots, k=5)
    for order, values in enumerate(SplinePath(knots).evaluate(s)):
        assert np.abs(values - expected(s, order)).max() < 1e-11 * n**order


def test_a_spline_passes_through_its_knots(rng):
    knots = rng.standard_normal((12, 3))
    path = SplinePath(knots, nq=2)
    q = path.evaluate(np.linspace(0, 1, 12), 0)[0]
    assert np.abs(q - knots).max() < 1e-12
    assert np.array_equal(path.end, knots[-1, :2])


def test_a_spline_through_too_few_knots_is_refused():
    with pytest.raises(ValueError):
        SplinePath(np.zeros((5, 1)))


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_straight_path_gives_as_many_derivatives_as_are_requested(order):
    path = StraightPath(np.array([1.0, 2.0]), np.array([2.0, 0.0]))
    expected = ([1.5, 1.0], [1.0, -2.0], [0.0, 0.0])[: order + 1]
    assert np.array_equal(np.squeeze(path.evaluate(np.array([0.5]), order)), np.squeeze(expected))
