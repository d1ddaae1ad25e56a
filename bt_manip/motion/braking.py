"""Coming to rest, from wherever a motion is."""

import numpy as np

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .clock_limits import Curve, Rows
from .effort import ALLOWED
from .halting import State, halting_clocks, shortest_rest
from .jerk_profile import JerkProfile
from .limit_check import EFFORT_STEP, ROUNDING, STEP, effort_use, greatest_effort, step_times
from .paced_trajectory import PacedTrajectory
from .trajectory import PathTrajectory, SequenceTrajectory, TailTrajectory, Trajectory

ENOUGH = 1.02  # times the least that any path leaves: who rests as soon as that need not look on
_EVERY = round(EFFORT_STEP / STEP)


def brake(trajectory: Trajectory, t: float, model: RobotModel) -> Trajectory:
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
    # Along a path itself the limits change least; as a motion over time it has corners of its own.
    if isinstance(whole, PathTrajectory):
        clock = _rested(*_on_path(whole, state), model, tail, tail.duration)
        if clock is not None:
            return PathTrajectory(whole.path, clock, whole.bounds)
    halted = halt(whole, state, model, tail.duration)
    return tail if halted is None else halted


def clock_along(trajectory: Trajectory, t: float) -> tuple[Trajectory, State]:
    """Give what is driven at some pace, and the state of the clock that goes along it."""
    if isinstance(trajectory, PacedTrajectory):
        return trajectory.whole, trajectory.clock.sample(t)
    return trajectory, (t, 1.0, 0.0)


def halt(whole: Trajectory, state: State, model: RobotModel, left: float) -> PacedTrajectory | None:
    """Bring the clock along a trajectory to rest, as soon as the limits allow.

    Args:
        whole: What is being driven.
        state: Its time now, the pace and the pace's change: [s], [-] and [1/s].
        model: The arm with its payload.
        left: How long the motion would go on [s].

    Returns:
        None where nothing rests sooner than the motion, or only with more effort than is allowed
        and than the motion itself takes.
    """
    if isinstance(whole, PathTrajectory):
        curve = Curve(whole.coordinates, whole.bounds, whole.duration)
    else:
        curve = Curve(whole.table, Bounds.of_joints(model.limits), whole.duration)
    clock = _rested(curve, state, model, TailTrajectory(whole, state[0]), left)
    return None if clock is None else PacedTrajectory(whole, clock)


def _on_path(whole: PathTrajectory, state: State) -> tuple[Curve, State]:
    """Give the path itself, and the state of the clock that goes along it."""
    now, pace, change = state
    s, ds, dds = whole.profile.sample(now)
    along = s, ds * pace, dds * pace * pace + ds * change

    def evaluate(places: np.ndarray) -> Rows:
        x, d1, d2 = whole.path.evaluate(places)
        return x, d1, d2

    return Curve(evaluate, whole.bounds, 1.0), along


def _rested(
    curve: Curve, state: State, model: RobotModel, tail: Trajectory, left: float
) -> JerkProfile | None:
    """Give the first clock that rests inside the limits before what is left of a motion does."""
    s, p, u = state
    _, d1, d2 = (rows[0] for rows in curve.evaluate(np.array([s])))
    if left <= ENOUGH * shortest_rest(d1 * p, d2 * p * p + d1 * u, curve.bounds):
        return None
    best: JerkProfile | None = None
    least: float | None = None  # effort of the best; that of the motion is seldom needed
    for looked in (None, model):  # at efforts: seldom do they ask for less than the joints' limits
        for clock in halting_clocks(curve, state, looked, ALLOWED, left):
            if clock.duration >= left:
                continue
            x, v, a = curve.driven(clock, step_times(clock.duration, STEP))
            if max(curve.bounds.use(v, a, STEP)) > 1.0 + ROUNDING:
                continue
            q, v, a = (rows[::_EVERY, : model.nq] for rows in (x, v, a))
            effort = greatest_effort(model, q, v, a)
            if effort <= ALLOWED:
                return clock
            if least is None:
                least = effort_use(tail, model)
            if effort < least:
                best, least = clock, effort
            if looked is None:
                break
        else:
            break  # efforts are not what is in the way
    return best


def _innermost(trajectory: Trajectory, t: float) -> tuple[Trajectory, float]:
    """Give what is driven at a time, without what comes before or behind it."""
    while True:
        if isinstance(trajectory, SequenceTrajectory):
            trajectory, t = trajectory.active(t)
        elif isinstance(trajectory, TailTrajectory):
            t += trajectory.since
            trajectory = trajectory.whole
        else:
            return trajectory, t
