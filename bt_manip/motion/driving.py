"""Paths from rest to rest, inside all limits."""

from collections.abc import Sequence

import numpy as np

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .effort import ALLOWED
from .errors import MotionError
from .jerk_profile import reach_profile
from .limit_check import effort_use
from .path_timing import GRIDS, time_optimal
from .paths import Path, StraightPath
from .trajectory import PathTrajectory

PASSES = 10
BETWEEN = 1.001  # between the steps that are looked at there is a little more


def drive_straight(
    start: np.ndarray, end: np.ndarray, model: RobotModel, speed: float = 1.0
) -> PathTrajectory:
    """Move on the straight line between two configurations, all joints in phase.

    Ruckig plans the one parameter; where that asks too much effort, the path is timed with the
    arm's dynamics.

    Args:
        start: Where the arm is at rest.  # (nq,)
        end: Where it comes to rest.  # (nq,)
        model: The arm with its payload.
        speed: At 0.5 the move takes twice the time.

    Raises:
        MotionError: When even standing on the way asks too much effort.
    """
    path, bounds = StraightPath(start, end), Bounds.of_joints(model.limits)
    way = np.abs(path.direction)
    moves = way > 0.0
    least = [float((bound[moves] / way[moves]).min()) for bound in bounds]
    profile = reach_profile((0.0, 0.0, 0.0), 1.0, (least[0], least[1], least[2]))
    trajectory = PathTrajectory(path, profile.slowed(1.0 / speed), bounds)
    if effort_use(trajectory, model) <= ALLOWED:
        return trajectory
    return drive(path, bounds, model, speed)


def drive(
    path: Path,
    bounds: Bounds,
    model: RobotModel,
    speed: float = 1.0,
    grids: Sequence[int] = GRIDS,
) -> PathTrajectory:
    """Drive any path as fast as limits and efforts let it.

    Args:
        path: The curve.
        bounds: What its coordinates may do.
        model: The arm with its payload.
        speed: At 0.5 the move takes twice the time.
        grids: As for `time_optimal`.

    Raises:
        MotionError: When even standing on the way asks too much effort.
    """
    profile = time_optimal(path, bounds, model, ALLOWED, grids).slowed(1.0 / speed)
    for _ in range(PASSES):
        trajectory = PathTrajectory(path, profile, bounds)
        velocity, acceleration, jerk = trajectory.use()
        used = BETWEEN * max(velocity, acceleration**0.5, jerk ** (1 / 3))
        effort = effort_use(trajectory, model) / ALLOWED
        if used <= 1.0 and effort <= 1.0:
            return trajectory
        profile = profile.slowed(max(1.0005 * used, 1.002 * effort**0.5 if effort > 1.0 else 1.0))
    raise MotionError(
        f"the motion asks for {100.0 * effort * ALLOWED:.0f} % of an effort limit even when slow, "
        f"{100.0 * ALLOWED:.0f} % are allowed",
        reason="effort",
    )
