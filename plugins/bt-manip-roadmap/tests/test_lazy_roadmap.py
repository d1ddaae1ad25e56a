"""Paths of a roadmap are free, short, and the same for the same seed."""

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.planning import PlanningProblem
from bt_manip.robots import JointLimits
from bt_manip_roadmap import LazyRoadmap

LIMITS = JointLimits(*(np.full(2, x) for x in (-2.0, 2.0, 1.0, 1.0, 1.0, 1.0)))
RADIUS = 0.5
SHORTEST = 2 * (np.sqrt(1 - RADIUS**2) + RADIUS * np.arcsin(RADIUS))
"""From (-1, 0) to (1, 0) around the disc: two tangents and the arc between them."""


def problem(is_free, seed=0, goals=((1.0, 0.0),)):
    rng = np.random.default_rng(seed)
    return PlanningProblem(np.array([-1.0, 0.0]), np.array(goals), is_free, LIMITS, rng)


def outside_the_disc(q):
    return bool(np.linalg.norm(q) > RADIUS)


def length(path):
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@pytest.mark.parametrize("seed", range(5))
def test_a_path_is_free_and_nearly_the_shortest(seed):
    path = LazyRoadmap().plan(problem(outside_the_disc, seed)).path
    np.testing.assert_array_equal(path[[0, -1]], [[-1.0, 0.0], [1.0, 0.0]])
    for start, end in zip(path, path[1:], strict=False):
        points = start + np.linspace(0.0, 1.0, 500)[:, np.newaxis] * (end - start)
        assert np.linalg.norm(points, axis=1).min() > RADIUS - 0.01
    assert length(path) < 1.15 * SHORTEST


def test_a_free_segment_needs_no_sample():
    result = LazyRoadmap().plan(problem(lambda q: True))
    assert result.samples == 0 and len(result.path) == 2


def test_of_several_goals_it_takes_the_nearest():
    goals = ((1.9, 1.9), (-1.0, 0.5))
    path = LazyRoadmap().plan(problem(lambda q: True, goals=goals)).path
    np.testing.assert_array_equal(path[-1], goals[1])


def test_the_same_seed_gives_the_same_path():
    first, second = (LazyRoadmap().plan(problem(outside_the_disc, 3)).path for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_without_a_path_it_gives_up_after_a_number_of_samples():
    given = problem(lambda q: q[0] < 0.0 or q[0] > 0.9)
    result = LazyRoadmap(samples=320).plan(given)
    assert result.path.size == 0 and result.samples == 320
    assert "320 samples" in result.reason
    state = np.random.default_rng(0)
    state.uniform(size=(320, 2))
    assert given.rng.random() == state.random()  # so many were drawn


def test_an_arm_can_be_told_to_use_it(parts):
    station = build_station(parts, planner="lazy_roadmap")
    assert isinstance(station.arm.planner, LazyRoadmap)
