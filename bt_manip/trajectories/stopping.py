"""Coming to rest, from wherever a motion is."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from .kinematic_limits import KinematicLimits
from .limit_check import (
    CONTROL_STEP,
    EFFORT_STEP,
    ROUNDING,
    effort_use,
    greatest_effort,
    jumps,
    sample_times,
)
from .motion_profile import MotionProfile
from .stop_search import halting_clocks, shortest_rest
from .time_scaling_limits import Curve, Rows, State
from .trajectory import (
    PathTrajectory,
    SequenceTrajectory,
    TailTrajectory,
    TimeScaledTrajectory,
    Trajectory,
)

ENOUGH = 1.02  # times the least that any path leaves: who rests as soon as that need not look on
ALLOWED = 0.98  # of every effort limit: more than to motions, which shall also be caught up with
_EVERY = round(EFFORT_STEP / CONTROL_STEP)


class _Way(NamedTuple):
    """What a clock can go along, to rest.

    Attributes:
        curve: What it goes through.
        state: Its reading, its pace and the pace's change.
        driven: Makes a motion of a clock.
    """

    curve: Curve
    state: State
    driven: Callable[[MotionProfile], Trajectory]


def plan_stop(trajectory: Trajectory, t: float, model: RobotModel) -> Trajectory:
    """Plan the way to rest from the middle of a trajectory, without leaving its path.

    Where nothing rests sooner inside the limits, the trajectory is driven to its end.

    Args:
        trajectory: What is being driven.
        t: Since its start [s].
        model: The arm with its payload.
    """
    trajectory, t = _innermost(trajectory, t)
    tail = TailTrajectory(trajectory, t)
    whole, state = clock_along(trajectory, t)
    ways = [_over_time(whole, state, model)]
    # Along a path itself the limits change least; as a motion over time it has corners of its own.
    if isinstance(whole, PathTrajectory):
        ways.insert(0, _on_path(whole, state))
    found = _halted(ways, model, tail, tail.duration)
    return tail if found is None else found[0].driven(found[1])


def clock_along(trajectory: Trajectory, t: float) -> tuple[Trajectory, State]:
    """Give what is driven at some pace, and the state of the clock that goes along it."""
    if isinstance(trajectory, TimeScaledTrajectory):
        return trajectory.nominal, trajectory.time_scaling.at(t)
    return trajectory, (t, 1.0, 0.0)


def halt(
    whole: Trajectory, state: State, model: RobotModel, left: float
) -> TimeScaledTrajectory | None:
    """Bring the clock along a trajectory to rest, as soon as the limits allow.

    Args:
        whole: What is being driven.
        state: Its time now, the pace and the pace's change: [s], [-] and [1/s].
        model: The arm with its payload.
        left: How long the motion would go on [s].

    Returns:
        None where nothing rests sooner than the motion, or only with more
        effort than is allowed and than the motion itself takes.
    """
    tail = TailTrajectory(whole, state[0])
    found = _halted([_over_time(whole, state, model)], model, tail, left)
    return None if found is None else TimeScaledTrajectory(whole, found[1])


def _over_time(whole: Trajectory, state: State, model: RobotModel) -> _Way:
    """Go along a motion over its own time."""
    corners = whole.breakpoints()
    if isinstance(whole, PathTrajectory):
        curve = Curve(whole.sample_coordinates, whole.limits, whole.duration, corners)
    else:
        curve = Curve(
            whole.sample, KinematicLimits.of_joints(model.limits), whole.duration, corners
        )
    return _Way(curve, state, lambda clock: TimeScaledTrajectory(whole, clock))


def _on_path(whole: PathTrajectory, state: State) -> _Way:
    """Go along the path itself."""
    now, pace, change = state
    s, ds, dds = whole.profile.at(now)
    along = s, ds * pace, dds * pace * pace + ds * change

    def evaluate(places: np.ndarray) -> Rows:
        x, d1, d2 = whole.path.evaluate(places)
        return x, d1, d2

    def driven(clock: MotionProfile) -> Trajectory:
        return PathTrajectory(whole.path, clock, whole.limits)

    return _Way(Curve(evaluate, whole.limits, 1.0, timed=False), along, driven)


def _halted(
    ways: list[_Way], model: RobotModel, tail: Trajectory, left: float
) -> tuple[_Way, MotionProfile] | None:
    """Give the first clock that rests inside the limits before what is left of a motion does."""
    curve, (s, p, u), _ = ways[0]
    _, d1, d2 = (rows[0] for rows in curve.evaluate(np.array([s])))
    shortest = shortest_rest(d1 * p, d2 * p * p + d1 * u, curve.bounds)
    if left <= ENOUGH * shortest:
        return None
    found: tuple[_Way, MotionProfile] | None = None
    for way in ways:
        clock = _at_once(way, model, tail, left, shortest)
        if clock is not None:
            found, left = (way, clock), clock.duration
            break
    return found


def _at_once(
    way: _Way, model: RobotModel, tail: Trajectory, left: float, shortest: float
) -> MotionProfile | None:
    """Brake as hard as each moment allows; None where that leads nowhere."""
    best: MotionProfile | None = None
    least: float | None = None  # effort of the best; that of the motion is seldom needed
    for looked in (None, model):  # at efforts: seldom do they ask for less than the joints' limits
        found: MotionProfile | None = None
        for clock in halting_clocks(way.curve, way.state, looked, ALLOWED, left):
            if found is not None and clock.duration >= found.duration:
                break  # the rounds have settled
            if clock.duration >= left:
                continue
            effort = _effort_inside(way.curve, clock, model)
            if effort <= ALLOWED:
                found = clock
                if clock.duration <= ENOUGH * shortest:
                    break
                continue
            if np.isinf(effort) or found is not None:
                continue
            if least is None:
                least = effort_use(tail, model)
            if effort < least:
                best, least = clock, effort
            if looked is None:
                break
        else:
            if found is None:
                break  # efforts are not what is in the way
        if found is not None:
            return found
    return best


def _effort_inside(curve: Curve, clock: MotionProfile, model: RobotModel) -> float:
    """Give the greatest share of an effort limit along a clock; infinite outside other limits."""
    x, v, a = curve.driven(clock, sample_times(clock.duration, CONTROL_STEP))
    beyond = max(curve.bounds.use(v, a, CONTROL_STEP)) > 1.0 + ROUNDING
    if beyond or jumps((x, v, a), curve.bounds.jerk):
        return np.inf
    q, v, a = (rows[::_EVERY, : model.nq] for rows in (x, v, a))
    return greatest_effort(model, q, v, a)


def _innermost(trajectory: Trajectory, t: float) -> tuple[Trajectory, float]:
    """Give what is driven at a time, without what comes before or behind it."""
    while True:
        if isinstance(trajectory, SequenceTrajectory):
            trajectory, t = trajectory.active(t)
        elif isinstance(trajectory, TailTrajectory):
            t += trajectory.start
            trajectory = trajectory.trajectory
        else:
            return trajectory, t
