"""The planner finds collision-free paths, equal for equal seeds."""

import numpy as np
import pytest
from bt_manip.planning import PlanningProblem
from bt_manip.robots import JointLimits

from bt_manip_gear.gear import Gear

LIMITS = JointLimits(*(np.full(2, x) for x in (-2.0, 2.0, 1.0, 1.0, 1.0, 1.0)))


def problem(is_free, seed=0):
    """Return the problem of crossing a plane."""
    start, goals = np.array([-1.0, 0.0]), np.array([[1.0, 0.0]])
    return PlanningProblem(start, goals, is_free, LIMITS, np.random.default_rng(seed))


def outside_the_circle(q):
    return bool(np.linalg.norm(q) > 0.5)


@pytest.mark.parametrize("seed", range(5))
def test_a_path_leads_from_start_to_goal_and_is_free(seed):
    path = Gear().plan(problem(outside_the_circle, seed)).path
    np.testing.assert_array_equal(path[[0, -1]], [[-1.0, 0.0], [1.0, 0.0]])
    for start, end in zip(path, path[1:], strict=False):
        points = start + np.linspace(0.0, 1.0, 500)[:, np.newaxis] * (end - start)
        assert np.linalg.norm(points, axis=1).min() > 0.49


def test_the_same_seed_gives_the_same_path():
    planner = Gear()
    first, second = (planner.plan(problem(outside_the_circle, 3)) for _ in range(2))
    np.testing.assert_array_equal(first.path, second.path)


def test_without_a_path_it_gives_up_after_a_number_of_samples():
    result = Gear(samples=50).plan(problem(lambda q: q[0] < 0.0))
    assert result.path.size == 0 and result.samples == 50
    assert "50 configurations" in result.reason
