"""Coming to rest, from wherever a motion is."""

import numpy as np

from bt_manip.robots import RobotModel

from .effort import ALLOWED
from .errors import MotionError
from .jerk_profile import brake_profile, joint_profiles
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

_FACTORS = (
    1.0,
    0.9,
    0.8,
    0.7,
    0.6,
    0.5,
    0.4,
    0.3,
    0.2,
)  # of acceleration and jerk, the hardest first
_AHEAD = np.linspace(0.0, 1.0, 20)


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
    if isinstance(trajectory, SequenceTrajectory):
        trajectory, t = trajectory.active(t)
    while isinstance(trajectory, TailTrajectory):
        t += trajectory.since
        trajectory = trajectory.whole
    if isinstance(trajectory, PacedTrajectory):
        slowed = paced(trajectory.whole, trajectory.clock.sample(t), 0.0, model)
    elif not isinstance(trajectory, PathTrajectory):
        slowed = paced(trajectory, (t, 1.0, 0.0), 0.0, model)
    else:
        slowed = None
    if slowed is not None:
        return slowed
    tail = TailTrajectory(trajectory, t)
    best: Trajectory = tail
    least: float | None = None  # effort of the best; that of the tail is seldom needed
    for factor in _FACTORS:
        trial: Trajectory | None
        try:
            if isinstance(trajectory, PathTrajectory):
                trial = _on_path(trajectory, t, factor)
            else:
                trial = _all_joints(state, model, factor)
        except MotionError:
            continue
        if trial is None or trial.duration >= tail.duration:
            continue
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


def _on_path(trajectory: PathTrajectory, t: float, factor: float) -> PathTrajectory | None:
    """Brake the parameter; whether the curvature allows it is for the caller to see."""
    s, ds, dds = trajectory.profile.sample(t)
    path, bounds = trajectory.path, trajectory.bounds
    slope = np.abs(path.evaluate(s + (1.0 - s) * _AHEAD, 1)[1]).max(axis=0)
    moves = slope > 0.0
    acceleration, jerk = (
        factor * float((bound[moves] / slope[moves]).min())
        for bound in (bounds.acceleration, bounds.jerk)
    )
    profile = brake_profile((s, ds, dds), (max(ds, 1e-6), acceleration, jerk))
    if not 0.0 <= profile.end <= 1.0:
        return None
    braked = PathTrajectory(path, profile, bounds)
    return braked if max(braked.use()) <= 1.0 + 1e-9 else None


def _all_joints(
    state: tuple[np.ndarray, np.ndarray, np.ndarray], model: RobotModel, factor: float
) -> JointTrajectory:
    limits = model.limits
    profiles = joint_profiles(
        state, None, limits.velocity, factor * limits.acceleration, factor * limits.jerk
    )
    return JointTrajectory(profiles)
