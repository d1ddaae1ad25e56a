"""Planning around obstacles, executed in simulation; processor time in ms.

``python -m benchmarks planning``; ``python -m benchmarks.bench_planning 200`` takes as many seeds
and scenes as given, which takes minutes.
"""

import sys
import time
from collections.abc import Iterator

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.planning import discretize_segment
from bt_manip.robots import RobotDescription
from tests.measuring.executions import LONG, execute_scenes
from tests.measuring.scenes import Planned, free_start, wall
from tests.measuring.time_optimal_duration import missing

COUNT = 20  # seeds and scenes
FINE_STEP = 2e-3  # [rad]
Row = tuple[str, str, str]


def rows(count: int = COUNT) -> list[Row]:
    """Measure everything, with a number of seeds and scenes."""
    return [*wall_rows(count), *scene_rows(count)]


def wall_rows(
    seeds: int, description: RobotDescription | None = None, scale: float = 1.0
) -> Iterator[Row]:
    """Plan around a wall, scaled to the reach of any robot."""
    planned, left, right = wall(description, scale)
    arm = planned.arm
    arm.guard = None  # the reference moves alone
    start = free_start(planned, left)
    times, free = [], 0
    for seed in range(seeds):
        arm.reset(start)
        begun = time.thread_time()
        try:
            arm.move_to_pose(right, rng=np.random.default_rng(seed))
        except MotionError:
            continue
        times.append(1e3 * (time.thread_time() - begun))
        free += not any(arm.world.collisions(q) for q in _fine(execute_reference(planned)))
    median, high = np.percentile(times, [50, 95])
    yield "wall: solved, and free every 0.002 rad", f"{free} of {seeds}", "all"
    yield (
        "wall: request to checked trajectory",
        f"{median:.0f} / {high:.0f} (median / 95 %)",
        "100 / 250; OMPL 58 with simplification",
    )


def scene_rows(count: int, description: RobotDescription | None = None) -> Iterator[Row]:
    """Execute motions among random obstacles, with any robot."""
    found = execute_scenes(count, description)
    executed = [one for one in found if not one.refused]
    median, high = np.percentile([one.planning for one in executed], [50, 95])
    ratios = [one.ratio for one in executed]
    yield (
        "random scenes: goal reached in simulation",
        f"{sum(one.reached for one in executed)} of {count} with a path, "
        f"{sum(not one.solvable for one in found)} without a path refused",
        "all, of 200",
    )
    missed = sum(one.solvable for one in found if one.refused)
    yield f"random scenes: refused, but solved with {LONG} samples", f"{missed}", "0"
    yield "random scenes: planning", f"{median:.0f} / {high:.0f} (median / 95 %)", ""
    yield (
        "random scenes: contacts, saturated",
        f"{sum(one.touched for one in executed)}, {sum(one.saturated for one in executed)} scenes",
        "0, 0",
    )
    yield (
        "random scenes: largest tracking error",
        f"{1e3 * max(one.error for one in executed):.2f} mrad",
        "2 mrad",
    )
    duration = np.median([one.duration for one in executed])
    yield "random scenes: duration", f"{duration:.2f} s (median)", ""
    yield (
        "random scenes: duration over the time-optimal one",
        missing() or f"{np.median(ratios):.3f} / {max(ratios):.3f} (median / maximum)",
        "1.15 / 1.4 (toppra, without jerk limits)",
    )


def execute_reference(planned: Planned) -> np.ndarray:
    """Advance the reference to its end and return its configurations."""
    found = [planned.arm.q_ref]
    while planned.arm.moving:
        planned.arm.advance(1e-3)
        found.append(planned.arm.q_ref)
    return np.array(found)


def _fine(q: np.ndarray, step: float = FINE_STEP) -> np.ndarray:
    return np.vstack(
        [q[:1], *(discretize_segment(a, b, step) for a, b in zip(q, q[1:], strict=False))]
    )


if __name__ == "__main__":
    for name, measured, reference in rows(int(sys.argv[1]) if len(sys.argv) > 1 else COUNT):
        print(f"{name:56} {measured:48} {reference}")
