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


@pytest.mark.parametrize("joint", range(7))
def test_beyond_a_position_limit_it_stays_at_the_limit(model, joint):
    for limit, side in ((model.limits.lower, -1.0), (model.limits.upper, 1.0)):
        q = model.home.copy()
        q[joint] = limit[joint]
        beyond = q + 0.2 * side * np.eye(7)[joint]
        found = differential_ik(model, q, model.pose(beyond))
        assert np.all((found >= model.limits.lower) & (found <= model.limits.upper))
        assert abs(found[joint] - limit[joint]) < 0.1


def test_redundant_joints_move_home_while_the_tool_stays(model):
    free = np.linalg.svd(model.jacobian(model.home))[2][-1]
    q = model.home + 0.2 * free
    T_wt = model.pose(q)
    for i in range(200):
        q = differential_ik(model, q, pin.SE3(np.eye(3), np.array([0, 0, 1e-3 * (i % 2)])) * T_wt)
    assert 0.0 < (q - model.home) @ free < 0.05
    assert np.linalg.norm(pin.log6(model.pose(q).actInv(T_wt)).np) < 2e-3


def test_joints_move_the_less_the_slower_they_are_and_home_only_where_the_tool_allows_it(model):
    rng, weights = np.random.default_rng(2), 1.0 / model.limits.velocity**2
    for _ in range(5):
        q = model.home + rng.uniform(-0.2, 0.2, 7)
        T_wt = model.pose(q) * pin.SE3(pin.exp3(rng.uniform(-2e-3, 2e-3, 3)), np.full(3, 1e-3))
        J, steps = model.jacobian(q), differential_ik(model, q, T_wt) - q
        free = np.linalg.svd(J)[2][-1]
        homing = 0.01 * (model.home - q) @ (weights * free) / (free @ (weights * free))
        # Weighted least squares: beyond homing, steps are orthogonal to motions of no effect.
        assert steps @ (weights * free) / (free @ (weights * free)) == pytest.approx(
            homing, rel=0.1
        )
