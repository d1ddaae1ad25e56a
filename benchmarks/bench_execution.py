"""Halts, pushes and unplanned contacts while motions are executed.

``python -m benchmarks execution``; ``python -m benchmarks.bench_execution 200`` takes as many cases
of each as are asked for, which takes minutes.
"""

import sys
from collections.abc import Iterator

import numpy as np

from bt_manip.robots import RobotDescription
from tests.measuring import disturbances
from tests.measuring.stops import halts

SOME = 20
Row = tuple[str, str, str]


def rows(count: int = SOME) -> list[Row]:
    """Measure everything with the Panda."""
    return [*halt_rows(count), *disturbance_rows(count)]


def halt_rows(count: int, description: RobotDescription | None = None) -> Iterator[Row]:
    """Halt motions of every kind, with any robot."""
    found = halts(count, description)
    ratios = [halt.ratio for halt in found]
    yield "halts: farthest off the path", f"{1e3 * max(h.off for h in found):.3f} mrad", "1 mrad"
    yield (
        "halts: most of a limit used (v, a, jerk, effort)",
        f"{100.0 * max(h.used for h in found):.2f} %",
        "100 %",
    )
    yield (
        "halts: duration over a time that none on the path can be below",
        f"{np.median(ratios):.3f} / {max(ratios):.3f} (median / most of {len(found)})",
        "1.1",
    )
    yield (
        "halts: processor time of a stop [ms]",
        "{:.1f} / {:.1f} (median / 99 %)".format(
            *np.percentile([h.computing for h in found], [50, 99])
        ),
        "3 / 30",
    )


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
