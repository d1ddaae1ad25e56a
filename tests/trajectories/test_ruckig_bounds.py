"""Times and distances of one coordinate, against Ruckig's time-optimal motions."""

import numpy as np
import pytest

from bt_manip.robots import MotionLimits
from bt_manip.trajectories.motion_profile import profile_to_velocity
from bt_manip.trajectories.path_limits import PathLimits
from bt_manip.trajectories.stop_search import shortest_stop_time


def test_no_coordinate_stops_faster_than_ruckig_stops_it():
    rng, one = np.random.default_rng(4), np.ones(1)
    for _ in range(100):
        bound, jerk = rng.uniform(1.0, 20.0), rng.uniform(50.0, 5000.0)
        v = rng.uniform(-2.0, 2.0) * 10.0 ** rng.uniform(-3.0, 0.0)
        a = rng.uniform(-bound, bound)
        limits = MotionLimits(-one, one, 9 * one, bound * one, jerk * one, one)
        shortest = shortest_stop_time(
            np.array([v]), np.array([a]), PathLimits(limits, np.empty((3, 0)))
        )
        ruckig = profile_to_velocity((0.0, v, a), 0.0, (bound, jerk)).duration
        assert shortest == pytest.approx(ruckig, rel=1e-6, abs=1e-9)
