"""The greatest path velocities under linear constraints."""

import numpy as np
import pytest

from bt_manip.trajectories.reachability import time_optimal_velocities


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("rate", [1e-2, -1e-2, 0.0])
def test_a_bend_within_one_step_slows_the_motion_there_and_stops_it_nowhere(rate, side):
    # A joint that hardly moves, limits of 1 on either side, bends at one of 121 points.
    rates, squares = np.tile([1.0, rate], (121, 1)), np.zeros((121, 2))
    squares[60, 1] = 50.0 * side
    limits, most = np.ones((121, 2)), np.full(121, 0.5)
    z = time_optimal_velocities(rates, squares, limits, limits, most)
    straight = time_optimal_velocities(rates, np.zeros((121, 2)), limits, limits, most)
    assert 0.9 / 50.0 < z[60] < 1.1 / 50.0
    assert z[1:-1].min() > 0.4 * z[60]
    # It speeds up and brakes by 2 u h = 1 / 60 in each step: 29 of them lead from 0.02 to 0.5.
    assert z[:30] == pytest.approx(straight[:30]) and z[91:] == pytest.approx(straight[91:])
