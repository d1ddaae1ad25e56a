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


def test_a_controller_that_the_run_switches_to_is_measured(parts):
    station, warnings = build_station(parts), []
    manager = station.controllers
    assert isinstance(manager, ControllerManager)
    manager.add("slow", Slow)
    stopwatch = Stopwatch({"slow": "controller 'slow' of mine"}, warnings.append)
    stopwatch.run_started(SimpleNamespace(station=station))
    for tick in range(6):
        if tick == 1:
            manager.switch("slow")
        station.cell.step(10)
        stopwatch.after_tick()
    stopwatch.run_ended()
    (warning,) = warnings
    assert warning.startswith("controller 'slow' of mine is slow: it takes ")
    assert "compute" not in vars(station.controller)


class Clock:
    """A controller whose calls take a given time [ms], and the clock that they are measured by."""

    now = 0.0

    def __call__(self):
        return self.now

    def compute(self, duration):
        self.now += 1e-3 * duration


FIRST = [900.0] * 10


@pytest.mark.parametrize(
    ("label", "durations", "warns"),
    [
        ("mine", [*FIRST, 0.6, 0.4, 0.6], True),
        ("mine", [*FIRST, 0.6, 0.4, 0.6, 0.4], False),  # not most of the calls
        ("mine", [*FIRST, 0.49, 0.49], False),
        ("mine", FIRST[:5], False),
        ("other", [*FIRST, 0.6, 0.6], False),
    ],
)
def test_most_calls_after_the_first_ten_have_to_be_slow(monkeypatch, label, durations, warns):
    clock, warnings = Clock(), []
    monkeypatch.setattr(time, "perf_counter", clock)
    robot = SimpleNamespace(controllers=SimpleNamespace(controller=clock, active="mine"))
    station = SimpleNamespace(cell=SimpleNamespace(dt=1e-3), robots={"arm": robot})
    stopwatch = Stopwatch({label: "It"}, warnings.append)
    stopwatch.run_started(SimpleNamespace(station=station))
    for duration in durations:
        clock.compute(duration)
        clock.now += 0.4e-3
        stopwatch.after_tick()
    stopwatch.run_ended()
    assert warnings == warns * [
        "It is slow: it takes 0.53 ms in each control step of 1 ms (53%), which is 57% of the "
        "time that a step takes; the results are the same"
    ]
