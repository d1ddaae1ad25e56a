"""Collision-free motions around a wall."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.planning import RRTConnect, collision_free_motion, discretize_segment

DT = 1e-3


@pytest.fixture
def arm(walled) -> Arm:
    arm = Arm(walled.robot, ik=walled.ik, world=walled.world)
    arm.reset(walled.ik.solve(walled.left, arm.model.home).q)
    return arm


def execute(arm) -> np.ndarray:
    """Advance the reference to its end and return its configurations."""
    rows = [arm.q.copy()]
    while arm.moving:
        arm.advance(DT)
        rows.append(arm.q.copy())
    return np.array(rows)


@pytest.mark.parametrize(("seed", "corners"), [(0, True), (1, True), (0, False)])
def test_the_arm_moves_around_the_wall_without_collision(walled, arm, seed, corners, monkeypatch):
    if not corners:  # where none are free it stops at each waypoint
        monkeypatch.setattr(collision_free_motion, "smooth_paths", lambda waypoints: ())
    arm.move_to_pose(walled.right, rng=np.random.default_rng(seed))
    q = execute(arm)
    fine = np.vstack([discretize_segment(a, b, 2e-3) for a, b in zip(q, q[1:], strict=False)])
    assert not any(walled.world.collisions(x) for x in fine)
    T = arm.model.pose(arm.q)
    assert T.translation == pytest.approx(walled.right.translation, abs=1e-5)


def test_an_arm_that_follows_moves_around_the_wall_to_a_moving_target(walled, arm):
    for tick in range(120):
        moved = np.array([0.02 * 25 * DT * tick, 0.0, 0.0])  # at 2 cm/s
        target = pin.SE3(walled.right.rotation, walled.right.translation + moved)
        arm.follow(target)
        for _ in range(25):
            arm.advance(DT)
        assert not walled.world.collisions(arm.q)
    assert np.linalg.norm(arm.model.pose(arm.q).translation - target.translation) < 2e-3


def test_the_arm_escapes_from_a_collision_at_the_start(walled, arm):
    T = walled.left.copy()
    T.translation = np.array([0.5, 0.25, 0.008])  # the finger tips are 3 mm inside the table
    arm.reset(walled.ik.solve(T, arm.q).q)
    assert walled.world.collisions(arm.q)
    arm.move_to_pose(walled.left)
    q = execute(arm)
    deepest = [min((n.distance for n in walled.world.collisions(x)), default=0.0) for x in q]
    assert min(deepest) >= deepest[0] - 1e-4 and deepest[-1] == 0.0


def test_without_a_path_the_error_names_the_colliding_bodies(walled, arm):
    class TooFewSamples:
        def plan(self, problem):
            return RRTConnect(samples=1).plan(problem)

    with pytest.raises(
        MotionError, match="no collision-free path: .* would touch 'wall'; no path found with 1 sam"
    ):
        arm.move_to_pose(walled.right, planner=TooFewSamples())
    assert not arm.moving
