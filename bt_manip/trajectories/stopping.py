"""Path-consistent stops: from a moving trajectory to rest without leaving its path."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from bt_manip.robots import CONTROL_STEP, ROUNDING, RobotModel

from .deceleration_limits import STOP_EFFORT_FRACTION, LimitedPath
from .limit_check import EFFORT_STEP, effort_use, has_jump, sampled_effort_use
from .motion_profile import MotionProfile, ScalarState
from .path_limits import PathLimits
from .stop_search import shortest_stop_time, stop_profiles
from .trajectory import (
    BlendedTrajectory,
    PathTrajectory,
    SequenceTrajectory,
    TailTrajectory,
    TimeScaledTrajectory,
    Trajectory,
    sample_times,
    time_scaling_state,
)

WORTHWHILE = 1.02  # times the shortest stop; a motion that ends by then is not stopped
_EFFORT_EVERY = round(EFFORT_STEP / CONTROL_STEP)


class _StopProblem(NamedTuple):
    """A path to stop on, from a state.

    Attributes:
        path: The path.
        start: s, s_dot and s_ddot.
        trajectory: Makes a trajectory of a profile of s.
    """

    path: LimitedPath
    start: ScalarState
    trajectory: Callable[[MotionProfile], Trajectory]


def plan_stop(trajectory: Trajectory, t: float, model: RobotModel) -> Trajectory:
    """Return a stop that stays on the path of a trajectory, as fast as its limits allow.

    The search evaluates a bounded number of profiles. Where none of them stops inside the limits
    before the trajectory ends, the rest of the trajectory is returned.

    Args:
        trajectory: The trajectory that is executed.
        t: Time since its start [s].
        model: The arm with its payload.
    """
    trajectory, t = _active(trajectory, t)
    tail = TailTrajectory(trajectory, t)
    nominal, state = time_scaling_state(trajectory, t)
    problems = [_stop_in_time(nominal, state, model)]
    if isinstance(nominal, PathTrajectory):  # its limits change less along the path than over time
        problems.insert(0, _stop_on_path(nominal, state, model))
    return _first_stop(problems, model, tail) or tail


def stop_time_scaling(
    nominal: Trajectory, state: ScalarState, model: RobotModel, tail: Trajectory
) -> TimeScaledTrajectory | None:
    """Return a stop as a time scaling of a nominal trajectory, so that it can be resumed.

    Args:
        nominal: The trajectory at speed scale 1.
        state: s, s_dot and s_ddot of the time scaling.
        model: The arm with its payload.
        tail: How the motion would go on.

    Returns:
        None where no stop is found that is shorter than that.
    """
    stop = _first_stop([_stop_in_time(nominal, state, model)], model, tail)
    assert stop is None or isinstance(stop, TimeScaledTrajectory)
    return stop


def _stop_in_time(nominal: Trajectory, state: ScalarState, model: RobotModel) -> _StopProblem:
    """Return the stop whose path parameter is the time of a trajectory."""
    others, evaluate = np.empty((3, 0)), nominal.sample
    if isinstance(nominal, PathTrajectory):
        others, evaluate = nominal.path.limits, nominal.sample_coordinates
    path = LimitedPath(evaluate, PathLimits(model.limits, others), nominal.duration)
    return _StopProblem(path, state, lambda profile: TimeScaledTrajectory(nominal, profile))


def _stop_on_path(nominal: PathTrajectory, state: ScalarState, model: RobotModel) -> _StopProblem:
    """Return the stop on the geometric path of a trajectory."""
    t, t_dot, t_ddot = state
    s, s_dot, s_ddot = nominal.profile.at(t)
    start = s, s_dot * t_dot, s_ddot * t_dot * t_dot + s_dot * t_ddot
    path = LimitedPath(nominal.path.evaluate, PathLimits(model.limits, nominal.path.limits), 1.0)
    return _StopProblem(path, start, lambda profile: PathTrajectory(nominal.path, profile))


def _first_stop(
    problems: Iterable[_StopProblem], model: RobotModel, tail: Trajectory
) -> Trajectory | None:
    """Return the first stop inside the limits that is shorter than the rest of the motion."""
    for problem in problems:
        path, (s, s_dot, s_ddot), _ = problem
        _, d1, d2 = (rows[0] for rows in path.evaluate(np.array([s])))
        velocity, acceleration = d1 * s_dot, d2 * s_dot * s_dot + d1 * s_ddot
        if tail.duration <= WORTHWHILE * shortest_stop_time(velocity, acceleration, path.limits):
            return None
        profile = _search(problem, model, tail)
        if profile is not None:
            return problem.trajectory(profile)
    return None


def _search(problem: _StopProblem, model: RobotModel, tail: Trajectory) -> MotionProfile | None:
    """Return the first profile inside the limits, with effort constraints where they matter."""
    path, start, _ = problem
    allowed, exceeded = STOP_EFFORT_FRACTION, False
    for constrained in (None, model):
        for profile in stop_profiles(path, start, constrained):
            if profile.duration >= tail.duration:
                break  # the next ones seldom are shorter
            effort = _effort_inside(path, profile, model)
            if allowed < effort < np.inf and not exceeded:
                allowed = max(allowed, effort_use(tail, model))  # not more than the motion itself
                exceeded = True
            if effort <= allowed:
                return profile
            if exceeded and constrained is None:
                break
        if not exceeded:
            break  # efforts do not matter
    return None


def _effort_inside(path: LimitedPath, profile: MotionProfile, model: RobotModel) -> float:
    """Return the largest used fraction of an effort limit; infinity outside other limits."""
    x, v, a = profile.sample_along(path.evaluate, sample_times(profile.duration, CONTROL_STEP))
    if max(path.limits.use(x, v, a)) > 1.0 + ROUNDING:
        return np.inf
    q = x[:, : model.nq]
    moved = np.diff(q, axis=0) / CONTROL_STEP  # faster than the velocities where these peak between
    if max(limited.use for limited in model.limits.speeds(q[:-1], moved)) > 1.0 + ROUNDING:
        return np.inf
    if has_jump((x, v, a), path.limits.jerk):
        return np.inf
    q, v, a = (rows[::_EFFORT_EVERY, : model.nq] for rows in (x, v, a))
    return sampled_effort_use(model, q, v, a)


def _active(trajectory: Trajectory, t: float) -> tuple[Trajectory, float]:
    """Return the innermost trajectory at a time, and its own time."""
    while True:
        if isinstance(trajectory, SequenceTrajectory):
            part, time = trajectory.active(t)
            if isinstance(trajectory, BlendedTrajectory) and part is not trajectory.parts[-1]:
                return trajectory, t  # the part does not end at rest
            trajectory, t = part, time
        elif isinstance(trajectory, TailTrajectory):
            t += trajectory.start
            trajectory = trajectory.trajectory
        else:
            return trajectory, t
