"""Selection of goal configurations and straight approaches."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.planning import goal_configurations, plan_straight_approach, translate_along_tool_z


def test_the_first_goal_is_the_nearest_solution_and_the_others_differ(walled):
    ik, home = walled.ik, walled.ik.model.home
    goals = list(goal_configurations(ik, walled.left, home, margin=0.05, world=walled.world))
    assert all(goal.solved for goal in goals) and len(goals) > 1
    distances = [ik.distance(goal.q, home) for goal in goals]
    assert distances[0] <= 1.01 * min(distances)  # with the margin kept
    for solution in ik.solutions(walled.left, home):
        assert min(np.abs(solution.q - goal.q).max() for goal in goals) <= 0.1


def test_with_an_approach_the_line_from_the_goal_is_free(walled):
    ik, above = walled.ik, translate_along_tool_z(walled.left, -0.1)
    (goal,) = goal_configurations(
        ik, above, ik.model.home, margin=0.05, approach=0.1, world=walled.world
    )
    approach = plan_straight_approach(ik, goal.q, walled.left, walled.world)
    assert approach.error is None and approach.limit_margin >= 0.05
    end = ik.model.pose(approach.end).translation
    assert end == pytest.approx(walled.left.translation, abs=1e-6)
    for last in (2.6, -2.6):  # rad of the last joint
        q, limits = goal.q + (last - goal.q[6]) * np.eye(7)[6], ik.model.limits
        line = plan_straight_approach(ik, q, translate_along_tool_z(ik.model.pose(q), 0.1), None)
        rows = line.curve.evaluate(np.linspace(0.0, 1.0, 200), 0)[0][:, :7]
        margin = np.minimum(rows - limits.lower, limits.upper - rows).min()
        assert line.limit_margin == pytest.approx(margin, abs=1e-4) and 0.1 < margin < 0.4


def test_an_approach_into_an_obstacle_returns_the_error_and_the_first_configuration(walled):
    ik = walled.ik
    q = ik.solve(walled.left, ik.model.home).q
    below = spatial.pointing_down(walled.left.translation - [0.0, 0.0, 0.2], 0.0)
    approach = plan_straight_approach(ik, q, below, walled.world)
    assert approach.limit_margin == -1.0 and np.array_equal(approach.end, q)
    assert "'top'" in str(approach.error)
