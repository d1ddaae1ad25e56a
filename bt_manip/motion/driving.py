"""Paths from rest to rest, inside all limits."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .effort import ALLOWED
from .errors import MotionError
from .jerk_profile import JerkProfile, reach_profile
from .limit_check import effort_use
from .path_timing import GRIDS, time_optimal
from .paths import Path, StraightPath
from .trajectory import PathTrajectory

PASSES = 10
LOST = 1.08  # times what was planned, by which a finer grid is tried
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
    return drive(path, bounds, model, speed, efforts_bind=True)


def drive(
    path: Path,
    bounds: Bounds,
    model: RobotModel,
    speed: float = 1.0,
    grids: Sequence[int] = GRIDS,
    *,
    efforts_bind: bool = False,
) -> PathTrajectory:
    """Drive any path as fast as limits and efforts let it.

    Args:
        path: The curve.
        bounds: What its coordinates may do.
        model: The arm with its payload.
        speed: At 0.5 the move takes twice the time.
        grids: As for `time_optimal`.
        efforts_bind: Whether it is known already that efforts limit the speed.

    Raises:
        MotionError: When even standing on the way asks too much effort.
    """
    # Few paths ask for more effort than there is when they are driven as fast as the joints may.
    for minded in (model,) if efforts_bind else (None, model):
        driven: list[_Driven] = []
        for number in range(len(grids)):
            profiles = time_optimal(path, bounds, minded, ALLOWED, grids[number:])
            driven += [
                _inside(path, profile.slowed(1.0 / speed), bounds, model, minded is not None)
                for profile in profiles
            ]
            fastest = min(driven, key=_merit)
            # A bend that the grid is too coarse for slows the whole motion.
            planned = min(profile.duration for profile in profiles) / speed
            if fastest.trajectory.duration <= LOST * planned:
                break
        if fastest.effort <= ALLOWED:
            return fastest.trajectory
    raise MotionError(
        f"the motion asks for {100.0 * fastest.effort:.0f} % of an effort limit even when "
        f"slow, {100.0 * ALLOWED:.0f} % are allowed",
        reason="effort",
    )


class _Driven(NamedTuple):
    """A plan, and the largest fraction of an effort limit that it asks for."""

    trajectory: PathTrajectory
    effort: float


def _merit(driven: _Driven) -> tuple[bool, float]:
    return driven.effort > ALLOWED, driven.trajectory.duration


def _inside(
    path: Path, profile: JerkProfile, bounds: Bounds, model: RobotModel, for_efforts: bool
) -> _Driven:
    """Slow a plan until it is inside all limits, or as often as is of use.

    Args:
        path: The curve.
        profile: The plan.
        bounds: What its coordinates may do.
        model: The arm with its payload.
        for_efforts: Whether it is slowed for the efforts too.
    """
    for tried in range(PASSES):
        trajectory = PathTrajectory(path, profile, bounds)
        velocity, acceleration, jerk = trajectory.use()
        used = BETWEEN * max(velocity, acceleration**0.5, jerk ** (1 / 3))
        if used > 1.0:  # slower in any case: its efforts need not be known
            profile = profile.slowed(1.0005 * used)
            continue
        effort = effort_use(trajectory, model)
        if effort <= ALLOWED or not for_efforts:
            return _Driven(trajectory, effort)
        profile = profile.slowed((1.0 + 2e-3 * 1.5**tried) * (effort / ALLOWED) ** 0.5)
    return _Driven(trajectory, effort_use(trajectory, model))
