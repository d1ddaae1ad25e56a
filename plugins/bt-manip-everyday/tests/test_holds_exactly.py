"""A box holds exactly what it is to hold: other objects count where they are, moving or not."""

import pytest

from bt_manip.bt import NodeStatus
from bt_manip.spatial import pose
from bt_manip_everyday.sentences import HoldsExactly

pytestmark = pytest.mark.start("a can in the box")


def test_a_can_that_falls_into_the_box_is_in_it_too(station, trial):
    condition = HoldsExactly(container="box", objects=["red_can"])
    assert trial(condition).tick() is NodeStatus.SUCCESS
    T_wb = station.cell.pose("box")
    station.cell.move("green_can", pose(T_wb.translation + (0.0, -0.08, 0.06)))
    station.cell.step(5)
    again = HoldsExactly(container="box", objects=["red_can"])
    assert trial(again).fails_with("'green_can' is in it, too")
