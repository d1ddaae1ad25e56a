"""Levenberg-Marquardt inside joint limits."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.kinematics import IKProblem, PoseTarget
from bt_manip.kinematics.levenberg_marquardt import DAMPING, levenberg_marquardt


def test_a_minimum_decrease_ends_an_unsuccessful_descent_sooner(model, compiled):
    unreachable, near = spatial.pointing_down([0.0, 0.0, 0.05]), model.pose(model.home + 0.1)

    def descent(T, min_decrease):
        problem = compiled(IKProblem(targets=PoseTarget("tool", T)))
        limits = problem.lower, problem.upper
        return levenberg_marquardt(
            problem.constraints, model.home, *limits, iterations=50, min_decrease=min_decrease
        )

    assert not descent(unreachable, 0.2).solved and not descent(unreachable, 0.0).solved
    assert 1 <= descent(unreachable, 0.2).iterations < descent(unreachable, 0.0).iterations
    assert np.array_equal(descent(near, 0.2).q, descent(near, 0.0).q) and descent(near, 0.2).solved


@pytest.mark.parametrize("away", [0.02, 0.3])
def test_a_step_far_from_limits_solves_the_damped_normal_equations(model, compiled, away):
    # Sugihara 2011: (J^T J + damping |e|^2) dq = -J^T e.
    problem = compiled(IKProblem(targets=PoseTarget("tool", model.pose(model.home + away))))
    residual, endless = problem.constraints, np.full(7, 100.0)
    error = residual.evaluate(model.home)
    jacobian = residual.jacobian()
    damped = jacobian.T @ jacobian + DAMPING * (error @ error) * np.eye(7)
    expected = -np.linalg.solve(damped, jacobian.T @ error)
    result = levenberg_marquardt(residual, model.home, -endless, endless, iterations=1)
    assert result.q - model.home == pytest.approx(expected, rel=1e-4, abs=1e-7)


def test_within_the_accepted_errors_it_is_solved_only_where_no_step_leads_nearer(model, compiled):
    # Nearer than the arm's tolerance at the start, and at what is desired after a few steps.
    problem = compiled(IKProblem(targets=PoseTarget("tool", model.pose(model.home + 5e-6))))
    for iterations, solved in ((0, False), (5, True)):
        result = levenberg_marquardt(
            problem.constraints, model.home, problem.lower, problem.upper, iterations=iterations
        )
        assert result.met and result.solved == solved
