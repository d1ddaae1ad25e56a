"""The wall problem for many seeds; it takes minutes."""

import numpy as np
import pytest

from bt_manip.arm import Arm
from bt_manip.planning import discretize_segment

pytestmark = pytest.mark.soak


def test_the_arm_moves_around_the_wall_without_collision_for_every_seed(walled):
    arm = Arm(walled.robot, ik=walled.ik, world=walled.world)
    start = walled.ik.solve(walled.left, arm.model.home).q
    for seed in range(200):
        arm.reset(start)
        arm.move_to_pose(walled.right, rng=np.random.default_rng(seed))
        q = [arm.q_ref]
        while arm.moving:
            arm.advance(1e-3)
            q.append(arm.q_ref)
        for a, b in zip(q, q[1:], strict=False):
            assert not any(walled.world.collisions(x) for x in discretize_segment(a, b, 2e-3)), seed
