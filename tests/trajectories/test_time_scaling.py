"""Changes of the speed scale of a joint that turns at constant velocity, known by hand."""

import numpy as np
import pytest

from bt_manip.trajectories import JointTrajectory, MotionProfile
from bt_manip.trajectories.time_scaling import change_speed_scale

from .pendulum import pendulum

TURNING = JointTrajectory([MotionProfile([[0.0, 0.0, 1.0, 0.0, 0.0]], 2.0, 2.0)])  # 1 rad/s


@pytest.mark.parametrize(("now", "new"), [(1.0, 0.2), (0.2, 1.0), (1.0, 0.5)])
def test_the_speed_changes_in_the_time_of_the_textbook_and_the_end_is_reached_then(now, new):
    # 4 rad/s2, whatever the jerk: |v1 - v0| / a, and 10 ms to smooth it.
    model = pendulum(acceleration=4.0, effort=1e4, jerk=1e4)
    change = change_speed_scale(TURNING, (1.5, now, 0.0), new, model)
    assert change is not None and change.near_optimal
    t = np.linspace(0.0, change.trajectory.duration, 20001)[:-1]
    s, s_dot, s_ddot = change.trajectory.time_scaling.sample(t)
    shortest = abs(new - now) / 4.0
    assert t[np.abs(s_ddot) > 1e-6].max() == pytest.approx(shortest, rel=0.05, abs=0.02)
    assert s_dot[0] == pytest.approx(now) and s_dot[-1] == pytest.approx(new)
    assert s[0] == 1.5 and s[-1] == pytest.approx(2.0, abs=1e-3)
    assert np.gradient(s, t)[1:-1] == pytest.approx(s_dot[1:-1], abs=1e-4)
    driven = np.diff(t) @ (s_dot[1:] + s_dot[:-1]) / 2.0
    assert driven == pytest.approx(2.0 - 1.5, rel=1e-3)
