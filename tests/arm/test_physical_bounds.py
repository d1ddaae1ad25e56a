"""Bounds of motions, by differences of the reference and distances of the collision world."""

import numpy as np
import pytest

from bt_manip.planning import plan_back_off

from .watch import DT


def depth(walled, q: np.ndarray) -> float:
    """Return the greatest penetration of the arm [m]."""
    return -min((pair.distance for pair in walled.world.collisions(q)), default=0.0)


@pytest.mark.parametrize("joint, aside", [(4, -0.05), (6, 0.05)])
def test_an_arm_pushed_along_a_wall_backs_off_without_going_deeper(walled, joint, aside):
    model = walled.robot.make_model()
    sweep = walled.ik.solve(walled.left, model.home).q - np.outer(
        np.arange(24) * 0.02, np.eye(7)[0]
    )
    path = sweep[::-1]  # the last configuration first
    touching = [depth(walled, q) > 0.0 for q in path].index(False) - 1
    q = path[touching] + aside * np.eye(7)[joint]  # moves along the wall
    assert np.abs(path - q).max(axis=1).argmin() < touching - 1  # rows inside are the nearest
    motion = plan_back_off(q, path, 0.1, walled.world, model, 1.0)
    rows = motion.sample(np.linspace(0.0, motion.duration, 60))[0]
    moved = model.pose(rows[-1]).translation - model.pose(q).translation
    assert np.linalg.norm(moved) == pytest.approx(0.1, abs=0.01) and moved[1] > 0.09
    assert max(depth(walled, row) for row in rows) <= depth(walled, q) + 1e-3


def test_a_redirected_arm_reaches_its_share_of_the_velocity_limit_and_keeps_it(arm, watch):
    speed = 0.6
    aside = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    arm.move_to_configuration(arm.model.home + 2.0 * aside, speed=speed)
    watch.run(300)
    arm.move_to_configuration(arm.model.home - 2.0 * aside, speed=speed)
    watch.rows = [watch.now()]
    watch.run()
    share = np.diff([row[0][0] for row in watch.rows]) / DT / arm.model.limits.velocity[0]
    assert np.abs(share).max() == pytest.approx(speed, rel=0.01)
