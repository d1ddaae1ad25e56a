"""Figures of a cycle over all of its robots."""

import pytest

from bt_manip.record.figures import combined
from bt_manip.record.report.run_report import RobotCycle

STILL = RobotCycle(("mug",), 10.0, max_torque_rate_nm_s=5.0)
MOVED = RobotCycle(("cube", "mug"), 20.0, max_tracking_error_rad=0.01, max_deflection_rad=0.2)


@pytest.mark.parametrize("robots", [(STILL, MOVED), (MOVED, STILL)])
def test_they_are_maxima_and_the_least_grip_force(robots):
    cycle = combined(robots)
    assert set(cycle.picked) == {"cube", "mug"} and len(cycle.picked) == 2
    assert (cycle.grip_force_n, cycle.max_deflection_rad) == (10.0, 0.2)
    assert (cycle.max_tracking_error_rad, cycle.max_torque_rate_nm_s) == (0.01, 5.0)
