"""Coming to rest, from wherever a motion is."""

import numpy as np

from bt_manip.robots import RobotModel

from .effort import ALLOWED
from .jerk_profile import brake_profile, joint_profiles
from .limit_check import effort_use, limit_use
from .trajectory import (
    JointTrajectory,
    PathTrajectory,
    SequenceTrajectory,
    TailTrajectory,
    Trajectory,
)

_FACTORS = (1.0, 0.7, 0.5, 0.35, 0.25)  # of acceleration and jerk, the hardest first


def brake(
    trajectory: Trajectory,
    t: float,
    state: tuple[np.ndarray, np.ndarray, np.ndarray],
    model: RobotModel,
) -> Trajectory:
    """Plan the way to rest from the middle of a trajectory.

    On a path the arm stays on the path. Elsewhere all joints come to rest at the same time. When
    the limits leave no better way, the trajectory is driven to its end.

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
    tail = TailTrajectory(trajectory, t)
    best: Trajectory = tail
    least = np.inf
    for factor in _FACTORS:
        trial = _trial(trajectory, t, state, model, factor)
        if trial is None or trial.duration >= tail.duration:
            continue
        if not limit_use(trial, model.limits).inside:
            continue
        effort = effort_use(trial, model)
        if effort <= ALLOWED:
            return trial
        if effort < least:
            best, least = trial, effort
    return best


def _trial(
    trajectory: Trajectory,
    t: float,
    state: tuple[np.ndarray, np.ndarray, np.ndarray],
    model: RobotModel,
    factor: float,
) -> Trajectory | None:
    if isinstance(trajectory, PathTrajectory):
        bounds = trajectory.braking.scaled(acceleration=factor)
        profile = brake_profile(trajectory.profile.sample(t), bounds)
        if not 0.0 <= profile.end <= 1.0:
            return None
        return PathTrajectory(trajectory.path, profile, trajectory.braking)
    limits = model.limits
    profiles = joint_profiles(
        state, None, limits.velocity, factor * limits.acceleration, factor * limits.jerk
    )
    return JointTrajectory(profiles)
