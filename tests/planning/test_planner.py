"""Planning problems."""

import numpy as np
import pytest

from bt_manip.planning import (
    PlanningProblem,
)
from bt_manip.robots import JointLimits


def test_multi_turn_joints_are_sampled_near_start_and_goals():
    one = np.ones(3)
    far = np.array([1.0, 2 * np.pi, np.inf])
    limits = JointLimits(-far, far, one, one, one, one)
    start, goals = np.array([0.0, 0.5, 0.0]), np.array([[0.5, -5.0, 1.0]])
    problem = PlanningProblem(start, goals, lambda q: True, limits, np.random.default_rng(0))
    lower, upper = problem.bounds()
    assert lower == pytest.approx([-1.0, -2 * np.pi, -np.pi])
    assert upper == pytest.approx([1.0, 0.5 + np.pi, 1.0 + np.pi])
