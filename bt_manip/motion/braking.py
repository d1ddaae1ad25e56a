"""Coming to rest, from wherever a motion is."""

from collections.abc import Iterator

import numpy as np

from bt_manip.robots import RobotModel

from .effort import ALLOWED
from .errors import MotionError
from .halting import Curve, halting_clocks
from .jerk_profile import joint_profiles
from .limit_check import effort_use, limit_use
from .paced_trajectory import PacedTrajectory
from .pacing import paced
from .trajectory import (
    JointTrajectory,
    PathTrajectory,
    SequenceTrajectory,
    TailTrajectory,
    Trajectory,
)

_FACTORS = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)  # of the limits, beside the path


def brake(
    trajectory: Trajectory,
    t: float,
    state: tuple[np.ndarray, np.ndarray, np.ndarray],
    model: RobotModel,
) -> Trajectory:
    """Plan the way to rest from the middle of a trajectory.

    The arm stays on the way that it was on. Where the limits leave no other way, all joints come to
    rest at the same time beside it, or the trajectory is driven to its end.

    Args:
        trajectory: What is being driven.
        t: Since its start [s].
        state: Reference position, velocity and acceleration now.  # (nq,) each
        model: The arm with its payload.
    """
    trajectory, t = _innermost(trajectory, t)
    tail = TailTrajectory(trajectory, t)
    best: Trajectory = tail
    least: float | None = None  # effort of the best; that of the tail is seldom needed
    for trials in (_on_the_way(trajectory, t, model), _beside_it(state, model)):
        for trial in trials:
            if trial.duration >= tail.duration:
                break  # those that come after it take even longer
            if not limit_use(trial, model.limits).inside:
                continue
            effort = effort_use(trial, model)
            if effort <= ALLOWED:
                return trial
            if least is None:
                least = effort_use(tail, model)
            if effort < least:
                best, least = trial, effort
    return best


def _innermost(trajectory: Trajectory, t: float) -> tuple[Trajectory, float]:
    """Give what is driven at a time, without what comes before or behind it."""
    while True:
        if isinstance(trajectory, SequenceTrajectory):
            trajectory, t = trajectory.active(t)
        elif isinstance(trajectory, TailTrajectory):
            trajectory, t = trajectory.whole, t + trajectory.since
        else:
            return trajectory, t


def _on_the_way(trajectory: Trajectory, t: float, model: RobotModel) -> Iterator[Trajectory]:
    clock = (t, 1.0, 0.0)
    if isinstance(trajectory, PacedTrajectory):
        trajectory, clock = trajectory.whole, trajectory.clock.sample(t)
    if isinstance(trajectory, PathTrajectory):
        now, pace, change = clock
        s, ds, dds = trajectory.profile.sample(now)
        yield from _on_path(trajectory, (s, ds * pace, dds * pace * pace + ds * change), model)
        return
    slowed = paced(trajectory, clock, 0.0, model)
    if slowed is not None:
        yield slowed


def _on_path(
    trajectory: PathTrajectory, state: tuple[float, float, float], model: RobotModel
) -> Iterator[PathTrajectory]:
    path, bounds = trajectory.path, trajectory.bounds

    def evaluate(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, d1, d2 = path.evaluate(s)
        return x, d1, d2

    for profile in halting_clocks(Curve(evaluate, bounds, 1.0), state, model, ALLOWED):
        braked = PathTrajectory(path, profile, bounds)
        if max(braked.use()) <= 1.0 + 1e-9:
            yield braked


def _beside_it(
    state: tuple[np.ndarray, np.ndarray, np.ndarray], model: RobotModel
) -> Iterator[JointTrajectory]:
    """Brake all joints by themselves, so that they come to rest at the same time."""
    limits = model.limits
    for factor in _FACTORS:
        acceleration, jerk = factor * limits.acceleration, factor * limits.jerk
        try:
            profiles = joint_profiles(state, None, limits.velocity, acceleration, jerk)
        except MotionError:
            continue
        yield JointTrajectory(profiles)
