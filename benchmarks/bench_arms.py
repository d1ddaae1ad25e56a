"""Other arms than the Panda, on what it is measured on; processor time in ms.

``python -m benchmarks arms``; ``python -m benchmarks.bench_arms 200 ur5e`` takes as many cases of
each kind, and the arms, that are asked for. It needs the package bt-manip-menagerie and the models
of MuJoCo Menagerie; where they are missing, the table says so.
"""

import sys
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.bench_execution import disturbance_rows, stop_rows
from benchmarks.bench_motion import inverse_kinematics_rows
from benchmarks.bench_planning import scene_rows, wall_rows
from bt_manip.exceptions import BtManipError, MotionError
from bt_manip.plugins import load_plugins
from bt_manip.robots import Robot, RobotDescription, compile_alone
from tests.measuring.scenes import SCALES

SOME = 6
POSES = 300
Row = tuple[str, str, str]


def rows(count: int = SOME, names: Sequence[str] = tuple(SCALES)) -> Iterator[Row]:
    """Measure each arm, with as many cases of each kind as are asked for."""
    robots = load_plugins().parts.robots
    for name in names:
        try:
            description = robots.get(name)
            robot = Robot(description)
            compile_alone(robot)
        except (BtManipError, OSError) as error:
            yield f"{name}: not measured", str(error).splitlines()[0][:60], ""
            continue
        for what, measured, beside in _measured(robot, description, count, SCALES.get(name, 1.0)):
            yield f"{name}: {what}", measured, beside


def _measured(
    robot: Robot, description: RobotDescription, count: int, scale: float
) -> Iterator[Row]:
    yield from inverse_kinematics_rows(robot.make_model(), POSES)
    try:
        yield from wall_rows(count, description, scale)
    except MotionError as error:
        yield "wall", f"not measured: {error}"[:60], ""
    yield from scene_rows(count, description)
    yield from stop_rows(count, description)
    yield from disturbance_rows(count, description)


if __name__ == "__main__":
    np.set_printoptions(precision=3)
    chosen = sys.argv[2:] or tuple(SCALES)
    for what, measured, beside in rows(int(sys.argv[1]) if len(sys.argv) > 1 else SOME, chosen):
        print(f"{what:72} {measured:52} {beside}", flush=True)
