"""Coming to rest, from wherever a motion is."""

from collections.abc import Iterator

import numpy as np

from bt_manip.robots import RobotModel

from .effort import ALLOWED
from .halting import Curve, halting_clocks
from .limit_check import effort_use, limit_use
from .paced_trajectory import PacedTrajectory
from .pacing import paced
from .trajectory import PathTrajectory, SequenceTrajectory, TailTrajectory, Trajectory


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
    best: Trajectory = tail
    least: float | None = None  # effort of the best; that of the tail is seldom needed
    for trial in _on_the_way(trajectory, t, model):
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
            t += trajectory.since
            trajectory = trajectory.whole
        else:
            return trajectory, t


def _on_the_way(trajectory: Trajectory, t: float, model: RobotModel) -> Iterator[Trajectory]:
    clock = (t, 1.0, 0.0)
    if isinstance(trajectory, PacedTrajectory):
        clock = trajectory.clock.sample(t)
        trajectory = trajectory.whole
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
