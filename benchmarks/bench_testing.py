"""What a test costs: going to a start situation, one behaviour, the first test of a session."""

import statistics
import subprocess
import sys
import time
from collections.abc import Callable

from bt_manip import build_station, spatial
from bt_manip.behaviours import (
    Drop,
    Grasp,
    Hover,
    IsHolding,
    Lift,
    MoveHome,
    MoveToConfiguration,
    OpenGripper,
    PlaceAt,
    Reach,
)
from bt_manip.bt import Action
from bt_manip.runner.station import Station
from bt_manip.testing.situations import (
    AROUND_THE_CUBE,
    AT_REST,
    HOLDING,
    Situations,
    built_in_situations,
)
from bt_manip.testing.trial import Trial

REPEATS = 7
# Times are those of the processor, not of the wall: nothing here waits, and other work on the
# machine does not count.

BEHAVIOURS = {
    "Hover": (AT_REST, lambda: Hover(object="cube", height=0.15)),
    "Reach": (AT_REST, lambda: Reach(object="cube")),
    "Grasp": (AROUND_THE_CUBE, lambda: Grasp(object="cube")),
    "Lift": (HOLDING, lambda: Lift(height=0.1)),
    "Drop": (HOLDING, lambda: Drop(container="basket")),
    "PlaceAt": (HOLDING, lambda: PlaceAt(object="cube", pose="0.35;-0.15;1.015")),
    "MoveHome": (HOLDING, MoveHome),
    "MoveToConfiguration": (
        AT_REST,
        lambda: MoveToConfiguration(configuration="0.1;-0.6;0.1;-2.2;0.1;1.6;0.9"),
    ),
    "OpenGripper": (HOLDING, OpenGripper),
    "IsHolding": (HOLDING, lambda: IsHolding(object="cube")),
}

FIRST = """
import os
os.environ["MUJOCO_GL"] = "disable"
import bt_manip.testing.situations, bt_manip.testing.trial, bt_manip.plugins, time
from bt_manip.behaviours import IsHolding
from bt_manip import build_station
start = time.process_time()
from bt_manip.plugins import load_plugins
parts = load_plugins().parts
situations = bt_manip.testing.situations.built_in_situations(lambda: build_station(parts))
station = situations.reset("holding a cube over the table")
trial = bt_manip.testing.trial.Trial(station, IsHolding(object="cube"))
trial.tick_until("SUCCESS")
print(time.process_time() - start)
"""

PLUGIN = """
import time, pytest, pluggy
start = time.process_time()
import bt_manip.testing.plugin
print(time.process_time() - start)
"""


def reset(situations: Situations, name: str) -> float:
    """Time going to a situation; median [s]."""
    times = []
    for _ in range(50):
        situations.reset(name).cell.step(5)
        start = time.process_time()
        situations.reset(name)
        times.append(time.process_time() - start)
    return statistics.median(times)


def add(station: Station) -> None:
    """Put a further object in."""
    cube = station.models.create("cube")
    station.cell.add(cube, spatial.pose((0.35, -0.2, 1.04)))


def take_away(station: Station) -> None:
    """Take the situation's own object away."""
    station.cell.remove("cube")


def reset_after_change(situations: Situations, change: Callable[[Station], None]) -> float:
    """Time going to a situation after a test that has changed what is there; median [s]."""
    times = []
    for _ in range(10):
        change(situations.reset(AT_REST))
        start = time.process_time()
        situations.reset(AT_REST)
        times.append(time.process_time() - start)
    return statistics.median(times)


def one_test(situations: Situations, start: str, behaviour: Action) -> tuple[float, float]:
    """Time a behaviour's test as a whole, and the control steps in it [s]."""
    began = time.process_time()
    station = situations.reset(start)
    trial = Trial(station, behaviour)
    stepping, step = 0.0, station.cell.step

    def timed(n: int = 1) -> None:
        nonlocal stepping
        before = time.process_time()
        step(n)
        stepping += time.process_time() - before

    station.cell.step = timed  # type: ignore[method-assign]
    try:
        trial.tick_until("SUCCESS", timeout=10.0)
    finally:
        del station.cell.step
    return time.process_time() - began, stepping


def process(code: str, runs: int = 3) -> float:
    """Run code in new interpreters that each print a time; median [s]."""
    times = []
    for _ in range(runs):
        done = subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True
        )
        times.append(float(done.stdout))
    return statistics.median(times)


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    situations = built_in_situations(build_station)
    found = [
        (f'reset to "{name}"', f"{1e3 * reset(situations, name):.2f} ms", "at most 5 ms")
        for name in situations.names
    ]
    for what, change in (("adds an object", add), ("takes one away", take_away)):
        after = reset_after_change(situations, change)
        row = (f"the same after a test that {what}", f"{1e3 * after:.1f} ms", "at most 5 ms")
        found.append(row)
    for name, (start, make) in BEHAVIOURS.items():
        tests = [one_test(situations, start, make()) for _ in range(REPEATS)]
        whole, stepping = min(tests, key=lambda test: test[0] - 1.3 * test[1])
        allowed = 0.010 + 1.3 * stepping
        found.append(
            (
                f"a test of {name}",
                f"{1e3 * whole:.1f} ms",
                f"at most {1e3 * allowed:.1f} ms; control steps {1e3 * stepping:.1f} ms",
            )
        )
    found.append(("first test of a session, after the imports", f"{process(FIRST):.2f} s",
                  "at most 2 s"))  # fmt: skip
    found.append(("what it costs all other sessions", f"{1e3 * process(PLUGIN):.1f} ms", ""))
    return found
