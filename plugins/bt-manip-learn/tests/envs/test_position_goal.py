"""Goals of positions."""

from types import SimpleNamespace

import pytest

from bt_manip_learn.envs.position_goal import PositionGoal


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_goal_has_three_coordinates_and_a_flag_for_each_condition(count):
    one = SimpleNamespace(destination="container", object="cube", container="basket")
    run = SimpleNamespace(tree=SimpleNamespace(goal=[one] * count))
    assert PositionGoal(SimpleNamespace(run=run)).size == 4 * count
