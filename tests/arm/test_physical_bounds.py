"""Bounds of motions, by differences of the reference and distances of the collision world."""

import numpy as np
import pytest

from bt_manip.arm import Arm
from bt_manip.planning import plan_back_off
from bt_manip.trajectories import plan_stop

DT = 1e-3


def measured_velocity(arm: Arm, steps: int) -> np.ndarray:
    """Advance and return the differences of the reference [rad/s]."""  # (steps, nq)
    rows = [arm.q.copy()]
    for _ in range(steps):
        arm.advance(DT)
        rows.append(arm.q.copy())
    return np.diff(rows, axis=0) / DT


def test_servo_to_a_distant_target_reaches_the_velocity_limit_and_keeps_it(arm):
    limits = arm.model.limits
    towards = np.where(arm.q > 0.5 * (limits.lower + limits.upper), limits.lower, limits.upper)
    speeds = []
    for _ in range(8):
        arm.servo(towards, np.zeros(7), 0.05)
        speeds.append(np.abs(measured_velocity(arm, 50)).max(axis=0) / limits.velocity)
    assert np.max(speeds) <= 1.0 + 1e-6
    assert np.max(speeds, axis=0)[0] > 0.95


def test_a_stop_ends_no_later_than_the_motion_would(arm, rng):
    limits = arm.model.limits
    for _ in range(8):
        goal = arm.model.home + rng.uniform(-0.5, 0.5, 7)
        arm.reset(arm.model.home)
        arm.move_to_configuration(goal.clip(limits.lower, limits.upper), speed=rng.uniform(0.3, 1))
        motion = arm.trajectory
        for left in [0.3, 0.1, 0.03, 0.01, *np.arange(1.0e-3, 2.6e-3, 1e-4)]:
            stop = plan_stop(motion, motion.duration - left, arm.model)
            assert stop.duration <= left + 1e-9


def depth(walled, q: np.ndarray) -> float:
    """Return the greatest penetration of the arm [m]."""
    return -min((pair.distance for pair in walled.world.collisions(q)), default=0.0)


@pytest.mark.parametrize("joint, aside", [(4, -0.05), (4, 0.05), (6, 0.05)])
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


@pytest.mark.parametrize("speed", [0.3, 0.6])
def test_a_redirected_arm_reaches_its_share_of_the_velocity_limit_and_keeps_it(arm, speed):
    aside = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    arm.move_to_configuration(arm.model.home + 2.0 * aside, speed=speed)
    measured_velocity(arm, 300)
    arm.move_to_configuration(arm.model.home - 2.0 * aside, speed=speed)
    share = np.abs(measured_velocity(arm, 2500)[:, 0]) / arm.model.limits.velocity[0]
    assert share.max() == pytest.approx(speed, rel=0.01)


@pytest.mark.parametrize("speed", [-0.5, 0.5])
def test_an_arm_whose_joint_turns_either_way_is_not_at_rest(arm, speed):
    assert arm.at_rest
    arm.robot.mj_data.qvel[arm.robot.dof_adr[1]] = speed
    try:
        assert not arm.at_rest
    finally:
        arm.robot.mj_data.qvel[:] = 0.0
