"""Motions back along a path, of a bar of 1 m: its tip moves by as much as it turns."""

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.planning import plan_back_off
from tests.trajectories.pendulum import pendulum


@pytest.mark.parametrize(
    ("distance", "end"), [(0.05, 0.47), (0.3, 0.22), (0.6, -0.08), (5.0, -0.3)]
)
def test_the_tool_moves_back_by_the_distance_along_the_travelled_path(distance, end):
    model, path = pendulum(effort=1e4), np.array([[0.6, 0.5, 0.4, 0.4, 0.25, 0.0, -0.3]]).T
    back, slow = (
        plan_back_off(np.array([0.52]), path, distance, None, model, speed) for speed in (1.0, 0.5)
    )
    assert back.end == pytest.approx([end], abs=2e-3)
    q = back.sample(np.linspace(0.0, back.duration, 200))[0][:, 0]
    assert q[0] == pytest.approx(0.52) and (np.diff(q) <= 1e-9).all()
    assert slow.duration == pytest.approx(2.0 * back.duration, rel=0.01)


def test_without_configurations_before_the_nearest_one_there_is_no_path_back():
    with pytest.raises(MotionError, match="no travelled path"):
        plan_back_off(np.array([0.52]), np.array([[0.6], [0.5]]), 0.1, None, pendulum(), 1.0)
