"""Time parameterization of paths from rest to rest, inside all limits."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel

from .limit_check import EFFORT_FRACTION, TOOL_SPEED_FRACTION, effort_use, tool_use
from .motion_profile import MotionProfile, profile_to_position
from .path_limits import PathLimits
from .paths import Path, SplinePath, StraightPath
from .topp import TOPP_GRIDS, TimeOptimalParameterization
from .trajectory import PathTrajectory, Trajectory

SLOWING_ITERATIONS = 10  # of slowing one profile until it is inside the limits
SMALL_SLOWDOWN = 1.01  # a profile that had to be slowed by less is not tightened
TIGHTENINGS = 2  # of the constraints, each after a profile that was slowed
GRID_SLOWDOWN = 1.03  # slowdown from which on a finer grid is tried
BETWEEN_STEPS = 1.001  # what the use of a limit may be greater by between two samples
EFFORT_ITERATIONS = 14  # of the bisection in `scale_to_effort_limits`
TOOL_KNOTS = 50  # of a straight path, for the length of the tool's path
TOOL_SAMPLES = 200  # of any path, at least, for this length
_FREE = (1e4, 1e7)  # acceleration and jerk of this length, which are not limited [m/s2, m/s3]
_FIRST_FACTOR = 0.7  # by which that reduces the scale until the first success
_CONVERGED = 0.97  # ratio of the best scale to the worst failing one, that ends it

AnyTrajectory = TypeVar("AnyTrajectory", bound=Trajectory)


def time_parameterize_segment(
    start: np.ndarray, end: np.ndarray, model: RobotModel, speed: float = 1.0
) -> PathTrajectory:
    """Return a fast trajectory along the joint-space segment between two configurations.

    Ruckig plans the path parameter. Where that exceeds effort limits, velocity limits near
    position limits, or the limit of the tool's speed, `time_parameterize` does.

    Args:
        start: Configuration at rest [rad].  # (nq,)
        end: Final configuration [rad].  # (nq,)
        model: The arm with its payload.
        speed: Fraction of the fastest speed, above 0 and at most 1.

    Raises:
        MotionError: When even holding the arm on the path exceeds an effort limit.
    """
    path, limits = StraightPath(start, end), model.limits
    distance = np.abs(path.direction)
    moves = distance > 0.0
    v, a, j = (
        float((limit[moves] / distance[moves]).min())
        for limit in (limits.velocity, limits.acceleration, limits.jerk)
    )
    profile = profile_to_position((0.0, 0.0, 0.0), 1.0, (v, a, j))
    trajectory = PathTrajectory(path, profile.slowed(1.0 / speed))
    if not limits.uniform and trajectory.kinematic_use(limits)[0] > 1.0:
        return time_parameterize(path, model, speed)
    if tool_use(trajectory, limits) > 1.0:
        return time_parameterize(path, model, speed)
    if effort_use(trajectory, model) <= EFFORT_FRACTION:
        return trajectory
    return time_parameterize(path, model, speed, effort_limited=True)


def time_parameterize(
    path: Path,
    model: RobotModel,
    speed: float = 1.0,
    grids: Sequence[int] = TOPP_GRIDS,
    *,
    effort_limited: bool = False,
) -> PathTrajectory:
    """Return a trajectory along a path that is nearly as fast as all limits allow.

    Args:
        path: The path.
        model: The arm with its payload.
        speed: Fraction of the fastest speed, above 0 and at most 1.
        grids: Numbers of grid intervals; the next one where bends are too sharp for the first.
        effort_limited: Whether effort limits are known to bound the speed.

    Raises:
        MotionError: When even holding the arm on the path exceeds an effort limit.
    """
    if model.limits.limits_tool:
        path = _with_tool(path, model)
    # Few paths exceed effort limits at the speed that the kinematic limits allow.
    for constrained in (model,) if effort_limited else (None, model):
        best = _fastest(path, model, constrained, speed, grids)
        if best.effort <= EFFORT_FRACTION:
            # The spline is inaccurate where the tool reverses.
            slower = tool_use(best.trajectory, model.limits)
            if slower > 1.0:
                return PathTrajectory(path, best.trajectory.profile.slowed(slower))
            return best.trajectory
    raise _effort_error(best.effort)


def _with_tool(path: Path, model: RobotModel) -> SplinePath:
    """Return a path with the length of the tool's path as its last coordinate, and its limits.

    Args:
        path: The path, which is kept: a spline gets no other knots.
        model: The arm, whose limits bound the speed of the tool.
    """
    if isinstance(path, SplinePath):
        knots = path.knots
    else:
        knots = path.evaluate(np.linspace(0.0, 1.0, TOOL_KNOTS), 0)[0]
    intervals = len(knots) - 1
    every = max(4, int(np.ceil(TOOL_SAMPLES / intervals)))
    q = path.evaluate(np.linspace(0.0, 1.0, every * intervals + 1), 0)[0][:, : path.nq]
    steps = np.linalg.norm(np.diff(model.tool_positions(q), axis=0), axis=1)
    length = np.append(0.0, np.cumsum(steps))[::every]
    speed = TOOL_SPEED_FRACTION * model.limits.tool_speed
    limits = np.column_stack([path.limits, (speed, *_FREE)])
    return SplinePath(np.column_stack([knots, length]), path.nq, limits)


def scale_to_effort_limits(
    plan: Callable[[float], AnyTrajectory], model: RobotModel
) -> AnyTrajectory:
    """Return a trajectory inside the effort limits, by bisection of a scale of its accelerations.

    Args:
        plan: Plans with accelerations and jerks scaled by a factor from 0 to 1.
        model: The arm with its payload.

    Raises:
        MotionError: When no scale keeps the effort limits.
    """
    best: AnyTrajectory | None = None
    good, bad, factor = 0.0, 1.0, 1.0
    effort = 0.0
    for _ in range(EFFORT_ITERATIONS):
        trajectory = plan(factor)
        effort = effort_use(trajectory, model)
        if effort <= EFFORT_FRACTION:
            best, good = trajectory, factor
        else:
            bad = factor
        if good >= _CONVERGED * bad:
            break
        factor = _FIRST_FACTOR * bad if best is None else 0.5 * (good + bad)
    if best is None:
        raise _effort_error(effort)
    return best


class _Candidate(NamedTuple):
    """A trajectory inside the kinematic limits.

    Attributes:
        trajectory: The trajectory.
        effort: Largest used fraction of an effort limit.
        slowdown: Its duration over that of the profile it was made of.
    """

    trajectory: PathTrajectory
    effort: float
    slowdown: float


def _fastest(
    path: Path,
    model: RobotModel,
    constrained: RobotModel | None,
    speed: float,
    grids: Sequence[int],
) -> _Candidate:
    """Return the fastest candidate.

    Without effort constraints (`constrained` is None) the first candidate that exceeds an effort
    limit ends the search: slowed for another limit it might keep that one, and yet be slower than
    with effort constraints.
    """
    found: list[_Candidate] = []

    def slow_down(profile: MotionProfile) -> _Candidate:
        return _slowed(path, profile.slowed(1.0 / speed), model, constrained is not None)

    def has_found(duration: float) -> bool:
        return any(
            one.effort <= EFFORT_FRACTION and one.trajectory.duration <= duration / speed
            for one in found
        )

    others = path.limits
    if model.limits.limits_tool:  # its speed is limited after slowing
        others = others.copy()
        others[0, -1] /= speed
    for grid in grids:
        topp = TimeOptimalParameterization(
            path, PathLimits(model.limits, others), constrained, grid
        )
        durations: list[float] = []
        for step in topp.smoothing_steps:
            profile = topp.profile(step)
            durations.append(profile.duration)
            if has_found(profile.duration):
                break
            for candidate in _tightened(topp, step, profile, slow_down):
                if constrained is None and candidate.effort > EFFORT_FRACTION:
                    return candidate
                found.append(candidate)
        # A bend that the grid cannot resolve slows the whole motion.
        if has_found(GRID_SLOWDOWN * durations[0]):
            break
    return min(found, key=lambda one: (one.effort > EFFORT_FRACTION, one.trajectory.duration))


def _tightened(
    topp: TimeOptimalParameterization,
    step: float,
    profile: MotionProfile,
    slow_down: Callable[[MotionProfile], _Candidate],
) -> Iterator[_Candidate]:
    """Yield candidates, each with constraints tightened where the previous one was slowed.

    Args:
        topp: Parameterization of the path.
        step: Smoothing step [s].
        profile: Its profile with this step.
        slow_down: Slows a profile until it is inside all limits.
    """
    candidate = slow_down(profile)
    yield candidate
    for _ in range(TIGHTENINGS):
        if candidate.slowdown <= SMALL_SLOWDOWN:
            break
        topp = topp.tightened(profile)
        tighter = topp.profile(step)
        if tighter.duration >= candidate.slowdown * profile.duration:
            break
        profile, candidate = tighter, slow_down(tighter)
        yield candidate


def _slowed(
    path: Path,
    profile: MotionProfile,
    model: RobotModel,
    keep_efforts: bool,
) -> _Candidate:
    """Return a candidate from a profile, slowed until it is inside its limits.

    Args:
        path: The path.
        profile: Path parameter over time.
        model: The arm with its payload.
        keep_efforts: Whether to slow it for effort limits too.
    """
    planned = profile.duration
    for iteration in range(SLOWING_ITERATIONS):
        trajectory = PathTrajectory(path, profile)
        velocity, acceleration, jerk = trajectory.kinematic_use(model.limits)
        use = BETWEEN_STEPS * max(velocity, acceleration**0.5, jerk ** (1 / 3))
        if use > 1.0:  # slowed in any case: its efforts need not be known
            profile = profile.slowed(1.0005 * use)
            continue
        effort = effort_use(trajectory, model)
        if effort <= EFFORT_FRACTION or not keep_efforts:
            break
        excess = (effort / EFFORT_FRACTION) ** 0.5
        profile = profile.slowed((1.0 + 2e-3 * 1.5**iteration) * excess)
    else:
        trajectory = PathTrajectory(path, profile)
        effort = effort_use(trajectory, model)
    return _Candidate(trajectory, effort, profile.duration / planned)


def _effort_error(effort: float) -> MotionError:
    return MotionError(
        f"the motion needs {100.0 * effort:.0f} % of an effort limit even when slow; "
        f"{100.0 * EFFORT_FRACTION:.0f} % are allowed",
        reason="effort",
    )
