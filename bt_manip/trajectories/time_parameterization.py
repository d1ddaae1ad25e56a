"""Paths from rest to rest, inside all limits."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel

from .effort import ALLOWED
from .kinematic_limits import KinematicLimits
from .limit_check import effort_use
from .motion_profile import MotionProfile, profile_to_position
from .path_timing import TOPP_GRIDS, PathTiming
from .paths import Path, StraightPath
from .trajectory import PathTrajectory

PASSES = 10
NEAR = 1.01  # times what was planned, beyond which the path is planned again
HEEDED = 2  # plans that the next ones may learn from
LOST = 1.03  # times what was planned, by which a finer grid is tried
BETWEEN = 1.001  # between the steps that are looked at there is a little more


def time_parameterize_segment(
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
    path, bounds = StraightPath(start, end), KinematicLimits.of_joints(model.limits)
    way = np.abs(path.direction)
    moves = way > 0.0
    least = [float((bound[moves] / way[moves]).min()) for bound in bounds]
    profile = profile_to_position((0.0, 0.0, 0.0), 1.0, (least[0], least[1], least[2]))
    trajectory = PathTrajectory(path, profile.slowed(1.0 / speed), bounds)
    if effort_use(trajectory, model) <= ALLOWED:
        return trajectory
    return time_parameterize(path, bounds, model, speed, efforts_bind=True)


def time_parameterize(
    path: Path,
    bounds: KinematicLimits,
    model: RobotModel,
    speed: float = 1.0,
    grids: Sequence[int] = TOPP_GRIDS,
    *,
    efforts_bind: bool = False,
) -> PathTrajectory:
    """Drive any path as fast as limits and efforts let it.

    Args:
        path: The curve.
        bounds: What its coordinates may do.
        model: The arm with its payload.
        speed: At 0.5 the move takes twice the time.
        grids: Steps that it is looked at in; a finer one where it bends too much for the first.
        efforts_bind: Whether it is known already that efforts limit the speed.

    Raises:
        MotionError: When even standing on the way asks too much effort.
    """
    # Few paths ask for more effort than there is when they are driven as fast as the joints may.
    for minded in (model,) if efforts_bind else (None, model):
        driven = _fastest(path, bounds, model, minded, speed, grids)
        if driven.effort <= ALLOWED:
            return driven.trajectory
    raise MotionError(
        f"the motion asks for {100.0 * driven.effort:.0f} % of an effort limit even when "
        f"slow, {100.0 * ALLOWED:.0f} % are allowed",
        reason="effort",
    )


def _fastest(
    path: Path,
    bounds: KinematicLimits,
    model: RobotModel,
    minded: RobotModel | None,
    speed: float,
    grids: Sequence[int],
) -> "_Driven":
    """Give the fastest of all plans inside the limits.

    Where efforts are not minded, the first plan that asks for too much ends the search: slowed for
    another limit it might ask for less, and yet be slower than one that minds them.
    """
    slow = 1.0 / speed

    def inside(plan: MotionProfile) -> _Driven:
        return _inside(path, plan.slowed(slow), bounds, model, minded is not None)

    found: list[_Driven] = []
    for grid in grids:
        timing = PathTiming(path, bounds, minded, ALLOWED, grid)
        for node in timing.nodes:
            if _done_within(slow * timing.plan(node).duration, found):
                break
            for driven in _better_and_better(timing, node, inside):
                if minded is None and driven.effort > ALLOWED:
                    return driven
                found.append(driven)
        # A bend that the grid is too coarse for slows the whole motion.
        if _done_within(slow * LOST * timing.plan(timing.nodes[0]).duration, found):
            break
    return min(found, key=_merit)


def _better_and_better(
    timing: PathTiming, node: float, inside: Callable[[MotionProfile], "_Driven"]
) -> Iterator["_Driven"]:
    """Plan again and again, as long as it is of use, each time knowing where the last was slowed.

    Args:
        timing: Of the path.
        node: What plans are smoothed over [s].
        inside: Slows a plan until it is inside all limits.
    """
    plan = timing.plan(node)
    driven = inside(plan)
    yield driven
    for _ in range(HEEDED):
        if driven.slowed <= NEAR:
            break
        timing = timing.keeping_off(plan)
        again = timing.plan(node)
        if again.duration >= driven.slowed * plan.duration:
            break
        plan, driven = again, inside(again)
        yield driven


class _Driven(NamedTuple):
    """A plan that is inside the limits.

    Attributes:
        trajectory: What it is.
        effort: The largest fraction of an effort limit that it asks for.
        slowed: How many times longer than planned it takes.
    """

    trajectory: PathTrajectory
    effort: float
    slowed: float

    @property
    def duration(self) -> float:
        """How long it takes [s]."""
        return self.trajectory.duration


def _merit(driven: _Driven) -> tuple[bool, float]:
    return driven.effort > ALLOWED, driven.duration


def _done_within(duration: float, found: list[_Driven]) -> bool:
    """Tell whether one of the plans is inside the efforts and takes no longer."""
    return any(one.effort <= ALLOWED and one.duration <= duration for one in found)


def _inside(
    path: Path,
    profile: MotionProfile,
    bounds: KinematicLimits,
    model: RobotModel,
    for_efforts: bool,
) -> _Driven:
    """Slow a plan until it is inside all limits, or as often as is of use.

    Args:
        path: The curve.
        profile: The plan.
        bounds: What its coordinates may do.
        model: The arm with its payload.
        for_efforts: Whether it is slowed for the efforts too.
    """
    planned = profile.duration
    for tried in range(PASSES):
        trajectory = PathTrajectory(path, profile, bounds)
        velocity, acceleration, jerk = trajectory.kinematic_use()
        used = BETWEEN * max(velocity, acceleration**0.5, jerk ** (1 / 3))
        if used > 1.0:  # slower in any case: its efforts need not be known
            profile = profile.slowed(1.0005 * used)
            continue
        effort = effort_use(trajectory, model)
        if effort <= ALLOWED or not for_efforts:
            break
        profile = profile.slowed((1.0 + 2e-3 * 1.5**tried) * (effort / ALLOWED) ** 0.5)
    else:
        trajectory = PathTrajectory(path, profile, bounds)
        effort = effort_use(trajectory, model)
    return _Driven(trajectory, effort, profile.duration / planned)
