"""Everyday objects have the shapes that they say, and are gripped where they are made for it."""

import numpy as np
import pytest

from bt_manip.behaviours import Grasp, Hover, Lift, Reach
from bt_manip.bt import Sequence
from bt_manip.cell import CellError
from bt_manip.spatial import pose
from bt_manip_everyday import Bowl, CoffeeMug

from .conftest import SURFACE


@pytest.mark.parametrize(("make", "held_at"), [(CoffeeMug, 0.0695), (Bowl, 0.061)])
def test_it_is_held_by_its_handle_or_by_its_rim(station, trial, make, held_at):
    yaw = 2.5
    T_wo = pose((0.35, 0.1, SURFACE), (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)))
    name = station.cell.add(make(), T_wo)
    steps = [Hover(object=name, height=0.1), Reach(object=name), Grasp(object=name)]
    trial(Sequence(*steps, Lift(height=0.1))).tick_until("SUCCESS", timeout=10.0)
    station.cell.step(300)
    T_wo = station.cell.pose(name)
    assert T_wo.translation[2] > SURFACE + 0.07
    assert station.gripper.width < 0.012
    x, y, _ = T_wo.actInv(station.robot.tool_pose.translation)
    assert np.hypot(x, y) == pytest.approx(held_at, abs=3e-3)


def test_a_handle_without_room_for_a_finger_is_refused():
    with pytest.raises(CellError, match="handle must be a number of at least 0.03 .m., got"):
        CoffeeMug(handle=0.01)
