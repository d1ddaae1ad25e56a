"""Stops, pushes and unplanned contacts while motions are executed.

``python -m benchmarks execution``; ``python -m benchmarks.bench_execution 200`` takes as many cases
of each as are asked for, which takes minutes.
"""

import sys
from collections.abc import Iterator

import numpy as np

from bt_manip.robots import RobotDescription
from tests.measuring import disturbances
from tests.measuring.stops import measure_stops

SOME = 20
Row = tuple[str, str, str]


def rows(count: int = SOME) -> list[Row]:
    """Measure everything with the Panda."""
    return [*stop_rows(count), *disturbance_rows(count)]


def stop_rows(count: int, description: RobotDescription | None = None) -> Iterator[Row]:
    """Stop motions of every kind, with any robot."""
    stops = measure_stops(count, description)
    off, used = max(stop.off_path for stop in stops), max(stop.limit_use for stop in stops)
    yield "stops: largest distance from the path", f"{1e6 * off:.1f} urad", "10 urad"
    yield "stops: largest use of a limit (v, a, jerk, effort)", f"{100.0 * used:.4f} %", "100 %"
    for what, values, allowed in (
        (
            "stops: duration over the longest of a joint alone",
            [stop.ratio for stop in stops],
            "1.02 / 2.5, xArm7 4.5",
        ),
        ("stops: CPU time [ms]", [stop.computing for stop in stops], "20 at most"),
    ):
        median, high, most = np.percentile(values, [50, 99, 100])
        yield what, f"{median:.3f} / {high:.2f} / {most:.2f} (median / p99 / max)", allowed


def disturbance_rows(count: int, description: RobotDescription | None = None) -> Iterator[Row]:
    """Push the hand, drive into what was not there, and do neither, with any robot."""
    for what, measure in (
        (f"pushes of {disturbances.FORCE:.0f} N", disturbances.pushes),
        (f"unplanned contacts over {disturbances.CONTACT_FORCE:.0f} N", disturbances.contacts),
    ):
        detected = measure(count, description)
        yield (
            f"{what}: detected within {disturbances.DETECTION_LIMIT} ms",
            f"{detected.in_time} of {count}, slowest {detected.slowest:.0f} ms, "
            f"{detected.false} false",
            "all, none false",
        )
    cycles = max(1, count // 2)
    false = disturbances.undisturbed(cycles, description)
    yield "motions with neither: stopped for nothing", f"{false} of {cycles}", "0 of 100"


if __name__ == "__main__":
    for what, measured, beside in rows(int(sys.argv[1]) if len(sys.argv) > 1 else SOME):
        print(f"{what:64} {measured:48} {beside}")
