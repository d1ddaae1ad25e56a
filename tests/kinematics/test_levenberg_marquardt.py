"""Levenberg-Marquardt inside joint limits."""

import numpy as np

from bt_manip import spatial
from bt_manip.kinematics import IKProblem, PoseTarget
from bt_manip.kinematics.levenberg_marquardt import levenberg_marquardt


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
