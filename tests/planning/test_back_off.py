"""Motions back along a path; the tip of a bar of 1 m moves by as much as it turns."""

import numpy as np
import pinocchio as pin
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


def test_from_a_contact_the_arm_backs_off_up_to_what_blocks_the_travelled_path(walled):
    # Across the wall to the left, and down until the finger tips are 3 mm inside the table.
    ik, q, rows = walled.ik, walled.ik.model.home, []
    down = [(0.25, z) for z in np.linspace(0.12, 0.008, 5)]
    for y, z in [(y, 0.12) for y in np.linspace(-0.25, 0.25, 15)] + down:
        T = pin.SE3(walled.left.rotation, np.array([0.5, y, z]))
        q = ik.follow(T, q, max_step=2.0).q
        rows.append(q)
    assert walled.world.collisions(q)
    travelled = np.array(rows[::-1])
    back = plan_back_off(q, travelled, 0.2, walled.world, ik.model, 1.0)
    moved = ik.model.pose(back.end).translation - ik.model.pose(q).translation
    assert moved == pytest.approx([0.0, 0.112 - 0.2, 0.112], abs=2e-3)
    with pytest.raises(MotionError, match="the path back is blocked: .* would touch 'wall'") as e:
        plan_back_off(q, travelled, 0.55, walled.world, ik.model, 1.0)
    assert e.value.reason == "collision"
