"""How much of its limits a trajectory uses."""

from typing import NamedTuple

import numpy as np

from bt_manip.robots import JointLimits, RobotModel

from .trajectory import Samples, Trajectory
from .trajectory import sample_times as sample_times

CONTROL_STEP = 1e-3  # [s] control step that references are sampled at
EFFORT_STEP = 4e-3  # [s] inverse dynamics vary slowly
ROUNDING = 1e-6  # relative; linear programmes leave half of that


class LimitUse(NamedTuple):
    """Largest fraction of each kind of limit that is used, over all joints and steps."""

    position: float
    velocity: float
    acceleration: float
    jerk: float

    @property
    def inside(self) -> bool:
        """Whether no limit is exceeded, but for rounding."""
        return max(self) <= 1.0 + ROUNDING


def limit_use(trajectory: Trajectory, limits: JointLimits, step: float = CONTROL_STEP) -> LimitUse:
    """Measure a trajectory as a controller sees it, step by step.

    The jerk is the difference of accelerations per step, the last partial step included.
    """
    return sampled_limit_use(
        trajectory.sample(sample_times(trajectory.duration, step)), limits, step
    )


def sampled_limit_use(rows: Samples, limits: JointLimits, step: float = CONTROL_STEP) -> LimitUse:
    """Measure what a trajectory does at equal steps of time [s], until it has ended."""
    q, v, a = rows
    middle, half = 0.5 * (limits.upper + limits.lower), 0.5 * (limits.upper - limits.lower)
    bounded = np.isfinite(half)
    position = np.abs(q - middle)[:, bounded] / half[bounded]
    jerk = np.diff(a, axis=0) / step
    moved = np.diff(q, axis=0) / step  # a jump of the position is a velocity too
    v = np.concatenate([v, moved])
    return LimitUse(
        float(position.max(initial=0.0)),
        float((np.abs(v) / limits.velocity).max()),
        float((np.abs(a) / limits.acceleration).max()),
        float((np.abs(jerk) / limits.jerk).max(initial=0.0)),
    )


def jumps(rows: Samples, jerk: np.ndarray, step: float = CONTROL_STEP) -> bool:
    """Tell whether positions at equal steps of time [s] change otherwise than by their velocities.

    With a jerk inside the limits, what a joint moves in a step differs from the mean of its two
    velocities times the step by at most a twelfth of jerk times step cubed (the error of the
    trapezoidal rule); twice that is no jump.

    Args:
        rows: Positions, velocities and accelerations.  # (n, m) each
        jerk: The limits of jerk.  # (m,)
        step: The time between the rows [s].
    """
    q, v, _ = rows
    off = np.diff(q, axis=0) - 0.5 * step * (v[1:] + v[:-1])
    return bool((np.abs(off) > jerk * step**3 / 6.0).any())


def effort_use(trajectory: Trajectory, model: RobotModel, step: float = EFFORT_STEP) -> float:
    """Give the largest fraction of an effort limit that a trajectory asks for.

    Rigid bodies, rotors, payload, damping and dry friction are counted. Between two times when the
    jerk changes the acceleration changes evenly: where these times are near each other, only they
    are looked at.
    """
    return greatest_effort(model, *trajectory.sample(effort_times(trajectory, step)))


def effort_times(trajectory: Trajectory, step: float = EFFORT_STEP) -> np.ndarray:
    """Give the times at which efforts are looked at."""
    times = trajectory.breakpoints()
    if np.diff(times, prepend=0.0, append=trajectory.duration).max() > 2.0 * step:
        times = np.unique(np.concatenate([sample_times(trajectory.duration, step), times]))
    return times


def greatest_effort(model: RobotModel, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> float:
    """Give the largest fraction of an effort limit that some states of motion ask for.

    Args:
        model: The arm with its payload.
        q: Positions [rad].  # (n, nq)
        v: Velocities [rad/s].  # (n, nq)
        a: Accelerations [rad/s2].  # (n, nq)
    """
    return float((np.abs(efforts(model, q, v, a)) / model.limits.effort).max())


def efforts(model: RobotModel, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Give what the motors have to do in some states of motion."""  # (n, nq)
    tau = np.array([model.rnea(*row) for row in zip(q, v, a, strict=True)])
    tau += model.damping * v + model.friction * np.sign(v)
    return tau
