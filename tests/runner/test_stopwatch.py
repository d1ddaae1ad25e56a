"""The stopwatch measures the controllers that a run uses, and warns of slow ones."""

import time
from types import SimpleNamespace

import pytest

from bt_manip import build_station
from bt_manip.control import ControllerManager, GravityCompensatedPD
from bt_manip.runner import Stopwatch


class Slow(GravityCompensatedPD):
    """Takes 2 ms, two control steps."""

    kind = "slow"

    def compute(self, *arguments):
        time.sleep(0.002)
        return super().compute(*arguments)


@pytest.fixture
def station(parts):
    station = build_station(parts)
    manager = station.controllers
    assert isinstance(manager, ControllerManager)
    manager.add("slow", Slow)
    return station


def measured(station, labels, switches=()):
    """Run 60 control steps with a stopwatch, and return its warnings."""
    warnings = []
    stopwatch = Stopwatch(labels, warnings.append)
    stopwatch.run_started(SimpleNamespace(station=station))
    for tick in range(6):
        if tick in switches:
            station.controllers.switch("slow")
        station.cell.step(10)
        stopwatch.after_tick()
    stopwatch.run_ended()
    return warnings


def test_a_controller_that_the_run_switches_to_is_measured(station):
    (warning,) = measured(station, {"slow": "controller 'slow' of mine"}, switches=(1,))
    assert warning.startswith("controller 'slow' of mine is slow: it takes ")
    assert "compute" not in vars(station.controller)


def test_fast_unused_and_unlabelled_controllers_give_no_warning(station):
    assert measured(station, {"computed_torque": "the default", "slow": "the other"}) == []
    assert measured(station, {}, switches=(0,)) == []
