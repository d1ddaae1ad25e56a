"""Gradients of costs; the oracle is numerical differentiation."""

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
    compiled = compile_problem(model, joints, problem, model.home, 1.0 / model.limits.velocity)
    assert isinstance(compiled.objectives, SecondaryObjectives)
    q = goal + 0.2
    expected = differentiate(compiled.cost, q)
    compiled.constraints.evaluate(q)
    expansion = compiled.objectives.expand(compiled.constraints)
    assert expansion.gradient == pytest.approx(expected, rel=1e-5, abs=1e-6)
    assert expansion.value == pytest.approx(compiled.cost(q))
