"""Largest used fractions of the limits of a trajectory."""

import numpy as np

from bt_manip.robots import CONTROL_STEP, LimitUse, MotionLimits, RobotModel

from .trajectory import Samples, Trajectory, sample_times

EFFORT_STEP = 4e-3  # [s] between inverse dynamics: efforts change little in that time
SMOOTH_EFFORT_STEP = 16e-3
"""The same where acceleration is linear in time [s]: efforts between are at most 2e-4 larger."""
TOOL_STEP = 0.01  # [s] between positions of the tool by which its speed is checked at first
TOOL_SPEED_FRACTION = 0.995  # of the tool's speed for motions: the rest is for changes of the scale
EFFORT_FRACTION = 0.95  # of every effort limit for motions: the rest is for the controller


def limit_use(trajectory: Trajectory, limits: MotionLimits) -> LimitUse:
    """Return the used fractions of a trajectory's limits, sampled at control steps.

    The jerk is the difference of accelerations per step, the last partial step included.
    """
    return limits.use(*trajectory.sample(sample_times(trajectory.duration, CONTROL_STEP)))


def tool_use(trajectory: Trajectory, limits: MotionLimits, start: float = 0.0) -> float:
    """Return the largest used fraction of the tool's speed that motions may have; 0 without one.

    The speed is that between positions at control steps, which are evaluated where those of
    `TOOL_STEP`, and their changes from one to the next, allow a larger one in between.

    Args:
        trajectory: The trajectory.
        limits: The limits, of whose speed of the tool motions use `TOOL_SPEED_FRACTION`.
        start: Time from which it is evaluated [s].
    """
    if not limits.limits_tool:
        return 0.0
    times = start + sample_times(max(trajectory.duration - start, 0.0), TOOL_STEP)
    use = limits.tool_use(trajectory.sample(times)[0], TOOL_STEP)
    change, largest = np.abs(np.diff(use, prepend=0.0, append=0.0)), float(use.max())
    bound = use + 2.0 * np.maximum(change[:-1], change[1:])
    between = times[:-1][bound > max(largest, TOOL_SPEED_FRACTION)]
    if len(between):
        steps = CONTROL_STEP * np.arange(round(TOOL_STEP / CONTROL_STEP) + 1)
        fine = limits.tool_use(
            trajectory.sample((between[:, None] + steps).ravel())[0], CONTROL_STEP
        )
        fine[len(steps) - 1 :: len(steps)] = 0.0  # from the end of one interval to the next one
        largest = max(largest, float(fine.max()))
    return largest / TOOL_SPEED_FRACTION


def has_jump(samples: Samples, jerk: np.ndarray) -> bool:
    """Tell whether positions at control steps change otherwise than by their velocities.

    With a jerk inside its limit, the displacement in a step differs from the mean of its two
    velocities times the step by at most a twelfth of jerk times step cubed (the error of the
    trapezoidal rule). Twice that is a jump.

    Args:
        samples: Positions, velocities and accelerations.  # (n, m) each
        jerk: Jerk limits.  # (m,)
    """
    q, v, _ = samples
    off = np.diff(q, axis=0) - 0.5 * CONTROL_STEP * (v[1:] + v[:-1])
    return bool((np.abs(off) > jerk * CONTROL_STEP**3 / 6.0).any())


def effort_use(trajectory: Trajectory, model: RobotModel) -> float:
    """Return the largest used fraction of an effort limit.

    Inverse dynamics of rigid bodies, rotors and payload, with damping and dry friction. Between two
    times at which the jerk changes the acceleration is linear in time: where these times are close
    to each other, only they are evaluated.
    """
    return sampled_effort_use(model, *trajectory.sample(effort_times(trajectory)))


def effort_times(trajectory: Trajectory) -> np.ndarray:
    """Return the times at which `effort_use` evaluates inverse dynamics [s]."""
    times = trajectory.breakpoints()
    if np.diff(times, prepend=0.0, append=trajectory.duration).max() > 2.0 * SMOOTH_EFFORT_STEP:
        every = sample_times(trajectory.duration, SMOOTH_EFFORT_STEP)
        times = np.sort(np.concatenate([every, times]))
    return times


def sampled_effort_use(model: RobotModel, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> float:
    """Return the largest used fraction of an effort limit over n states of motion.

    Args:
        model: The arm with its payload.
        q: Positions [rad].  # (n, nq)
        v: Velocities [rad/s].  # (n, nq)
        a: Accelerations [rad/s2].  # (n, nq)
    """
    return float((np.abs(motor_efforts(model, q, v, a)) / model.limits.effort).max())


def motor_efforts(model: RobotModel, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Return inverse dynamics with damping and dry friction at n states of motion."""  # (n, nq)
    tau = np.array([model.rnea(*row) for row in zip(q, v, a, strict=True)])
    tau += model.damping * v + model.friction * np.sign(v)
    return tau
