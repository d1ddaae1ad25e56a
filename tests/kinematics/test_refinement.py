"""Refinement of solutions: costs are lowest nearby, and constraints stay met."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.kinematics import (
    IKProblem,
    PoseTarget,
    PositionTarget,
    RotationTarget,
    manipulability,
)
from bt_manip.kinematics.refinement import refine
from bt_manip.kinematics.residuals import StackedResidual
from bt_manip.kinematics.secondary_objectives import QuadraticModel, SecondaryObjectives
from tests.measuring.kinematics import position_error, rotation_error

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)


def test_a_cost_is_met_as_far_as_the_constraints_allow(model, ik):
    elbow = np.array([0.1, 0.5, 0.6])
    pose = PoseTarget("tool", DOWN)
    without = ik.solve(IKProblem(targets=[pose]), model.home)
    cost = PositionTarget("link4", elbow, weight=1.0)
    with_it = ik.solve(IKProblem(targets=[pose, cost]), model.home)
    assert with_it.solved
    assert position_error(model, with_it.q, "tool", DOWN.translation) <= 1e-6
    near, far = (position_error(model, r.q, "link4", elbow) for r in (with_it, without))
    assert near < far - 0.05
    assert with_it.cost == pytest.approx(0.5 * near**2, rel=1e-6)
    # Along the self-motion, the only way that the constraint leaves, the cost does not fall.
    *_, rows = np.linalg.svd(model.jacobian(with_it.q))
    costs = [
        position_error(model, with_it.q + step * rows[6], "link4", elbow) ** 2
        for step in (-2e-2, 0.0, 2e-2)
    ]
    assert costs[1] <= min(costs) + 1e-5


def test_a_posture_is_approached_in_the_null_space_as_is_the_present_configuration(model, ik, rng):
    posture = model.home + np.array([0.5, 0.0, -0.4, 0.0, 0.3, 0.0, 0.0])
    plain = ik.solve(DOWN, model.home)
    found = ik.solve(IKProblem(targets=PoseTarget("tool", DOWN), posture=posture), model.home)
    assert found.solved and ik.distance(found.q, posture) < ik.distance(plain.q, posture) - 1e-3
    q0 = model.home + rng.uniform(-0.3, 0.3, 7)
    nearest = ik.nearest(spatial.pointing_down([0.4, 0.2, 0.4], 0.5), q0)
    for q, wanted in ((found.q, posture), (nearest.q, q0)):
        # The gradient of the weighted squared distance has no part along the self-motion.
        *_, rows = np.linalg.svd(model.jacobian(q))
        gradient = (q - wanted) / model.limits.velocity**2
        assert abs(gradient @ rows[6]) < 0.02 * np.linalg.norm(gradient)


def test_manipulability_is_raised_where_the_target_leaves_freedom(model, ik):
    rotation = RotationTarget("tool", DOWN.rotation)
    start = model.home + np.array([0.0, 0.6, 0.0, 1.6, 0.0, -1.0, 0.0])
    plain = ik.solve(IKProblem(targets=rotation), start)
    able = ik.solve(IKProblem(targets=rotation, manipulability=1.0), start)
    assert able.solved and rotation_error(model, able.q, "tool", DOWN.rotation) <= 1e-6
    before, after = (manipulability(model.jacobian(r.q)) for r in (plain, able))
    assert after > 1.2 * before
    assert able.cost == pytest.approx(-np.log(after), rel=1e-6)


def test_a_joint_on_which_a_cost_does_not_depend_stays_and_bounds_are_the_ends_of_others(model):
    home, hessian = model.home, np.diag([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    hessian[1, 2] = hessian[2, 1] = 0.5

    class Bowl(SecondaryObjectives):
        def __init__(self):
            pass

        def expand(self, constraints):
            offset = constraints.q - home - 0.3
            gradient = hessian @ offset + 1e-15  # of rounding
            return QuadraticModel(0.5 * float(offset @ hessian @ offset), gradient, hessian)

    upper = home + np.array([3.0, 0.1, 3.0, 3.0, 3.0, 3.0, 3.0])
    found = refine(StackedResidual(model, []), Bowl(), home, home - 3.0, upper)
    # The second joint ends 0.2 before the minimum: 2 x - 0.5 * 0.2 = 0 for the third one beyond it.
    expected = home + np.array([0.0, 0.1, 0.35, 0.3, 0.3, 0.3, 0.3])
    assert found.q == pytest.approx(expected, abs=1e-4)
    assert found.cost == pytest.approx(0.5 * (0.2**2 - 0.5 * 0.2 * 0.05 * 2 + 2.0 * 0.05**2))
