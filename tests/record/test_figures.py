"""Figures of a cycle over all of its robots."""

from dataclasses import fields

import pytest

from bt_manip.record.figures import CycleFigures, RunFigures, combined
from bt_manip.record.report.run_report import CycleLimitUse, RobotCycle, TrackingPeak

STILL = RobotCycle(("mug",), 10.0, max_torque_rate_nm_s=5.0)
MOVED = RobotCycle(("cube", "mug"), 20.0, max_tracking_error_rad=0.01, max_deflection_rad=0.2)


@pytest.mark.parametrize("robots", [(STILL, MOVED), (MOVED, STILL)])
def test_they_are_maxima_and_the_least_grip_force(robots):
    cycle = combined(robots)
    assert set(cycle.picked) == {"cube", "mug"} and len(cycle.picked) == 2
    assert (cycle.grip_force_n, cycle.max_deflection_rad) == (10.0, 0.2)
    assert (cycle.max_tracking_error_rad, cycle.max_torque_rate_nm_s) == (0.01, 5.0)


def test_those_of_one_robot_are_its_own():
    peak, use = TrackingPeak("joint1", "Reach", 0.5, 1.0), CycleLimitUse(0.5, 0.4, 0.3, 0.2)
    own = RobotCycle(("mug",), 10.0, 0.01, peak, 0.2, use, 3, 5.0, 0.7)
    assert all(getattr(own, one.name) != one.default for one in fields(RobotCycle))
    assert combined([own]) == own


def test_cycles_are_numbered_from_1():
    assert CycleFigures().number == RunFigures({}).cycle(0.0).number == 1
