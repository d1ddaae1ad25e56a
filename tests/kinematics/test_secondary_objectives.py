"""Gradients of costs; the oracle is numerical differentiation."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.kinematics import IKProblem, PoseTarget
from bt_manip.kinematics.compiled_problem import compile_problem
from bt_manip.kinematics.secondary_objectives import SecondaryObjectives
from tests.measuring.kinematics import differentiate, frame_pose


def test_the_gradient_of_all_costs_is_their_derivative(model, ik, goal):
    problem = IKProblem(
        targets=[PoseTarget("link6", frame_pose(model, goal, "link6"), weight=2.0)],
        posture=model.home,
        posture_weight=0.5,
        manipulability=0.3,
    )
    joints = tuple(model.model.names)[1:]
    q, moving = goal + 0.2, np.arange(7) != 2
    fixed = IKProblem(manipulability=0.3, joints=np.array(joints)[moving].tolist())
    for stated, mask in ((problem, 1.0), (fixed, moving)):
        compiled = compile_problem(model, joints, stated, model.home, 1.0 / model.limits.velocity)
        expected = differentiate(compiled.cost, q) * mask
        compiled.constraints.evaluate(q)
        _, gradient, hessian = compiled.objectives.expand(compiled.constraints)
        assert gradient == pytest.approx(expected, rel=1e-5, abs=1e-6)
    assert hessian == pytest.approx(0.3 * np.eye(7))  # the logarithm's changes by 1 a radian
    signed = np.linalg.det(model.jacobian(q)[:, moving])
    assert compiled.cost(q) == pytest.approx(-0.3 * np.log(abs(signed)))


def test_a_posture_costs_half_the_mean_square_of_the_times_to_it():
    # The time of each joint at its greatest speed: 0.2 s, 0.1 s and 0.4 s.
    speed, away = np.array([1.0, 2.0, 0.5]), np.array([0.2, -0.2, 0.2])
    objectives = SecondaryObjectives(1.0 / speed, posture=(np.ones(3), 3.0))
    cost = objectives.expand(SimpleNamespace(q=np.ones(3) + away))
    assert cost.value == pytest.approx(0.5 * 3.0 * (0.2**2 + 0.1**2 + 0.4**2) / 3.0)
    assert cost.gradient == pytest.approx(3.0 * away / speed**2 / 3.0)
    assert cost.hessian == pytest.approx(np.diag(1.0 / speed**2))
