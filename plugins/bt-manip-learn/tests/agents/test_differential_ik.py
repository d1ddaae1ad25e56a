"""Steps of inverse kinematics that agents take; the oracle is forward kinematics."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.robots import Robot, compile_alone, panda
from bt_manip_learn.agents.differential_ik import differential_ik


@pytest.fixture(scope="module")
def model():
    robot = Robot(panda())
    compile_alone(robot)
    return robot.make_model()


def test_a_near_pose_is_reached_inside_the_limits(model):
    rng = np.random.default_rng(0)
    for _ in range(20):
        q = model.home + rng.uniform(-0.3, 0.3, 7)
        near = pin.SE3(pin.exp3(rng.uniform(-0.05, 0.05, 3)), rng.uniform(-0.02, 0.02, 3))
        T_wt = model.pose(q) * near
        found = differential_ik(model, q, T_wt)
        assert np.linalg.norm(pin.log6(model.pose(found).actInv(T_wt)).np) < 2e-3
        assert np.all((found >= model.limits.lower) & (found <= model.limits.upper))
