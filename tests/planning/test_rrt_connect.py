"""RRT-Connect in a plane, where paths are easy to judge."""

import numpy as np
import pytest

from bt_manip.planning import PlanningProblem, RRTConnect, edge_is_free
from bt_manip.robots import JointLimits

from .test_path_simplification import beside_the_wall


def plane(is_free, start=(-1.0, 0.0), goals=((1.0, 0.0),), seed=0) -> PlanningProblem:
    """Return a problem with two joints, each from -2 to 2 rad."""
    one = np.ones(2)
    limits = JointLimits(-2 * one, 2 * one, one, one, one, one)
    rng = np.random.default_rng(seed)
    return PlanningProblem(np.array(start), np.array(goals), is_free, limits, rng)


def test_it_finds_a_path_around_a_wall_for_every_seed():
    for seed in range(10):
        problem = plane(beside_the_wall, seed=seed)
        found = RRTConnect().plan(problem)
        assert found.reason == "" and found.samples > 0
        assert np.array_equal(found.path[0], problem.start)
        assert np.array_equal(found.path[-1], problem.goals[0])
        for a, b in zip(found.path, found.path[1:], strict=False):
            assert edge_is_free(a, b, beside_the_wall, 0.04)


def test_of_several_goals_it_finds_one_that_can_be_reached():
    def is_free(q):  # the first goal is walled in
        return not 0.2 < np.abs(q - [1.0, 0.0]).max() < 0.4

    found = RRTConnect().plan(plane(is_free, goals=((1.0, 0.0), (0.0, 1.5))))
    assert np.array_equal(found.path[-1], [0.0, 1.5])


@pytest.mark.parametrize("seed", range(2))
def test_it_finds_the_way_out_of_a_narrow_passage_along_joint_limits(seed):
    one = np.ones(4)
    limits = JointLimits(-2 * one, 2 * one, one, one, one, one)

    def is_free(q):  # up to 0.5 rad of the first joint all others have to stay near their limits
        return q[0] > 0.5 or (q[1:] > 1.8).all()

    start, goal = np.array([-1.9, 1.9, 1.9, 1.9]), np.array([1.9, -1.0, -1.0, -1.0])
    rng = np.random.default_rng(seed)
    found = RRTConnect().plan(PlanningProblem(start, goal[np.newaxis], is_free, limits, rng))
    assert found.reason == "" and np.array_equal(found.path[-1], goal)
    for a, b in zip(found.path, found.path[1:], strict=False):
        assert edge_is_free(a, b, is_free, 0.04)
    assert (found.path >= limits.lower).all() and (found.path <= limits.upper).all()


def test_it_gives_up_after_a_number_of_samples():
    found = RRTConnect(samples=50).plan(plane(lambda q: abs(q[0]) > 0.2))
    assert not len(found.path)
    assert found.samples == 50 and "50 samples" in found.reason
    in_one = RRTConnect(samples=1).plan(plane(lambda q: True, goals=((1.0, 0.0), (1.0, 0.5))))
    assert in_one.samples == 1 and len(in_one.path) == 3


def test_multi_turn_joints_are_sampled_near_start_and_goals():
    one = np.ones(3)
    far = np.array([1.0, 2 * np.pi, np.inf])
    limits = JointLimits(-far, far, one, one, one, one)
    start, goals = np.array([0.0, 0.5, 0.0]), np.array([[0.5, -5.0, 1.0]])
    problem = PlanningProblem(start, goals, lambda q: True, limits, np.random.default_rng(0))
    lower, upper = problem.bounds()
    assert lower == pytest.approx([-1.0, -2 * np.pi, -np.pi])
    assert upper == pytest.approx([1.0, 0.5 + np.pi, 1.0 + np.pi])


def test_the_same_problem_gives_the_same_path():
    first, second = (RRTConnect().plan(plane(beside_the_wall, seed=5)) for _ in range(2))
    assert np.array_equal(first.path, second.path) and first.samples == second.samples
