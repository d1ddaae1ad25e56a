"""The planner goes around what is in the way, always in the same way."""

import numpy as np
import pytest
from bt_manip.planning import PlanningProblem
from bt_manip.robots import JointLimits

from bt_manip_gear.gear import Gear

LIMITS = JointLimits(*(np.full(2, x) for x in (-2.0, 2.0, 1.0, 1.0, 1.0, 1.0)))


def problem(free, seed=0):
    """Go through the middle of a plane from one side to the other."""
    start, goals = np.array([-1.0, 0.0]), np.array([[1.0, 0.0]])
    return PlanningProblem(start, goals, free, LIMITS, np.random.default_rng(seed))


def round_the_middle(q):
    return bool(np.linalg.norm(q) > 0.5)


@pytest.mark.parametrize("seed", range(5))
def test_a_path_leads_from_start_to_goal_and_is_free(seed):
    path = Gear().plan(problem(round_the_middle, seed)).path
    np.testing.assert_array_equal(path[[0, -1]], [[-1.0, 0.0], [1.0, 0.0]])
    for start, end in zip(path, path[1:], strict=False):
        line = start + np.linspace(0.0, 1.0, 500)[:, np.newaxis] * (end - start)
        assert np.linalg.norm(line, axis=1).min() > 0.49


def test_the_same_seed_gives_the_same_path():
    planner = Gear()
    first, second = (planner.plan(problem(round_the_middle, 3)) for _ in range(2))
    np.testing.assert_array_equal(first.path, second.path)


def test_where_there_is_no_way_it_says_so_after_a_count():
    planning = Gear(samples=50).plan(problem(lambda q: q[0] < 0.0))
    assert planning.path.size == 0 and planning.samples == 50
    assert "50 configurations" in planning.reason
