"""Motion in the null space of the tool's Jacobian."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.kinematics import null_space_step
from tests.measuring.kinematics import random_configurations
from tests.robot_fixtures import menagerie_robot


def test_a_step_moves_the_tool_like_the_other_step(model, rng):
    for q in random_configurations(model, rng, 20):
        dq = 1e-3 * rng.normal(size=7)
        step = null_space_step(model, q, dq, 1e-3)
        wanted, got = (pin.log6(model.pose(q).actInv(model.pose(q + d))).np for d in (dq, step))
        assert got == pytest.approx(wanted, abs=1e-4 * np.linalg.norm(step) + 2e-5)


def test_a_step_moves_joints_away_from_their_limits(model, rng):
    lower, upper = model.limits.sampling_bounds()
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    for q in random_configurations(model, rng, 20):
        step = null_space_step(model, q, np.zeros(7), 1e-3)
        normalized = (q - middle) / half
        assert normalized**3 @ step < 0.0
        _, values, (*_, free) = np.linalg.svd(model.jacobian(q))  # the last one keeps the tool
        if values[-1] > 0.1:  # away from singularities
            expected = -1e-3 * (normalized**3 @ free) * free
            assert step == pytest.approx(expected, rel=0.02, abs=5e-6)


def test_without_redundancy_the_step_stays(menagerie):
    model, dq = menagerie_robot(menagerie, "ur5e").make_model(), 1e-3 * np.arange(6.0)
    assert np.array_equal(null_space_step(model, model.home, dq, 1e-3), dq)
