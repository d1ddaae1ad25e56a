"""The greatest path velocities under linear constraints."""

import numpy as np
import pytest
from scipy.optimize import linprog

from bt_manip.trajectories.reachability import time_optimal_velocities


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("rate", "bend", "limit"),
    [(1e-2, 50.0, 1.0), (-1e-2, 50.0, 1.0), (0.0, 50.0, 1.0), (0.0, 0.9, 0.1)],
)
def test_a_bend_within_one_step_slows_the_motion_there_and_stops_it_nowhere(
    rate, bend, limit, side
):
    # A joint that hardly moves bends at one of 121 points.
    rates, squares = np.tile([1.0, rate], (121, 1)), np.zeros((121, 2))
    squares[60, 1] = bend * side
    above, below = np.tile([1.0, limit], (121, 1)), np.tile([1.0, 0.8 * limit], (121, 1))
    most = np.full(121, 0.5)
    z = time_optimal_velocities(rates, squares, above, below, most)
    straight = time_optimal_velocities(rates, np.zeros((121, 2)), above, below, most)
    # In one of 120 steps, a half of x is lost by u = 30 x.
    largest = (limit if side > 0.0 else 0.8 * limit) / (bend - 30.0 * abs(rate))
    assert z[60] == pytest.approx(largest)
    assert z[30:91].min() > 0.4 * z[60]
    # It speeds up and brakes by 2 u h = 1 / 60 in each step: 29 of them lead from 0.02 to 0.5.
    assert z[:30] == pytest.approx(straight[:30]) and z[91:] == pytest.approx(straight[91:])


@pytest.mark.parametrize("seed", [0, 1, 5])
def test_the_greatest_velocities_are_those_of_a_linear_program(seed):
    rng, n, k = np.random.default_rng(seed), 20, 3
    a = rng.uniform(0.5, 2.0, (n, k)) * rng.choice([-1.0, 1.0], (n, k))
    b = rng.uniform(-4.0, 4.0, (n, k))
    a[rng.random((n, k)) < 0.2] = 0.0
    above, below = rng.uniform(0.3, 2.0, (2, n, k))
    most, rows, bounds = rng.uniform(0.3, 5.0, n), [], []
    for i in range(n - 1):  # u is constant from a point to the next one
        change = (np.arange(n) == i + 1) - 1.0 * (np.arange(n) == i)
        for point in (i, i + 1):
            for j in range(k):
                row = a[point, j] * (n - 1) / 2.0 * change + b[point, j] * (np.arange(n) == point)
                rows += [row, -row]
                bounds += [above[point, j], below[point, j]]
    ends = np.where(np.isin(np.arange(n), (0, n - 1)), 0.0, most)
    best = linprog(-np.ones(n), rows, bounds, bounds=[(0.0, end) for end in ends])
    found = time_optimal_velocities(a, b, above, below, most)
    assert best.status == 0 and (found < 0.99 * ends).sum() > n / 2
    np.testing.assert_allclose(found, best.x, atol=1e-9)
