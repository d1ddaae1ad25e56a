"""Changes of the speed scale of a trajectory while it is executed.

With the time s of the nominal trajectory as path parameter and the speed scale s_dot, the joints
have the velocity ``v s_dot`` and the acceleration ``a s_dot^2 + v s_ddot``. So the greatest s_ddot
of either sign that acceleration and effort limits allow is known at each s, and a forward pass
integrates the fastest change.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from bt_manip.robots import CONTROL_STEP, RobotModel

from .limit_check import EFFORT_FRACTION, EFFORT_STEP, effort_use, has_jump, sampled_effort_use
from .motion_profile import (
    MotionProfile,
    ScalarState,
    check_duration,
    integrate_acceleration,
    profile_to_velocity,
)
from .path_constraints import PathDynamics
from .path_limits import TINY
from .stopping import stop_time_scaling
from .trajectory import TimeScaledTrajectory, Trajectory, sample_times

POINTS = 160  # of the rest of the trajectory at which the limits are evaluated
SMOOTHING_STEP = 5e-3  # [s] s_ddot is averaged over two steps and linear in between
MAX_CHANGE_STEPS = 400  # of a change, which bounds its size
LIMIT_FRACTIONS = (0.995, 0.97, 0.9, 0.8, 0.6, 0.4, 0.2)  # of the limits, tried in turn
NEAR_OPTIMAL = 0.8  # smallest of these with which a change need not be improved
RISE_TIMES = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)  # [s] from rest, tried where no margin succeeds
OVERSHOOT = 1.001  # of the speed scale, where the speed of the tool is limited
MAX_S_DDOT = 100.0  # [1/s]
_SMALL_CORRECTION = 0.25  # of a change, up to which it is corrected in proportion


class SpeedScaleChange(NamedTuple):
    """A change of the speed scale.

    Attributes:
        trajectory: The trajectory from now on.
        near_optimal: Whether the change is about as fast as the limits allow. It is not while a
            joint brakes near its limit, or the speed scale is already changing fast.
    """

    trajectory: TimeScaledTrajectory
    near_optimal: bool


def change_speed_scale(
    nominal: Trajectory, state: ScalarState, speed_scale: float, model: RobotModel
) -> SpeedScaleChange | None:
    """Return a fast change of the speed scale inside all limits.

    Args:
        nominal: The trajectory at speed scale 1.
        state: s, s_dot and s_ddot now: [s], [-] and [1/s].
        speed_scale: The new speed scale, 0 to 1; 0 comes to rest.
        model: The arm with its payload.

    Returns:
        None where the limits allow no change now, as while a joint brakes at its limit, or shortly
        before the end.

    Raises:
        MotionError: When the motion would take too long.
    """
    s, s_dot, s_ddot = state
    if s >= nominal.duration:
        return None
    if speed_scale > 0.0:
        check_duration((nominal.duration - s) / speed_scale)
    if s_dot == speed_scale and s_ddot == 0.0:
        return SpeedScaleChange(at_speed_scale(nominal, s, speed_scale), True)
    if speed_scale == 0.0:
        stop = stop_time_scaling(nominal, state, model, at_speed_scale(nominal, s, s_dot))
        return None if stop is None else SpeedScaleChange(stop, True)
    changes = _changes(nominal, state, speed_scale, model)
    for margin, (trajectory, changing) in zip(LIMIT_FRACTIONS, changes, strict=True):
        if _inside(trajectory, changing, speed_scale, model):
            return SpeedScaleChange(trajectory, margin >= NEAR_OPTIMAL)
    for trajectory, changing in _rises(nominal, s, speed_scale) if s_dot == s_ddot == 0.0 else ():
        if _inside(trajectory, changing, speed_scale, model):
            return SpeedScaleChange(trajectory, False)
    return None


def at_speed_scale(nominal: Trajectory, s: float, speed_scale: float) -> TimeScaledTrajectory:
    """Return the rest of a trajectory from its time s [s] on, at a constant speed scale."""
    left, end = (0.0, s) if speed_scale == 0.0 else (nominal.duration - s, nominal.duration)
    duration = left / max(speed_scale, TINY)
    profile = MotionProfile([[0.0, s, speed_scale, 0.0, 0.0]], duration, end)
    return TimeScaledTrajectory(nominal, profile)


def _inside(
    trajectory: TimeScaledTrajectory, changing: float, speed_scale: float, model: RobotModel
) -> bool:
    """Tell whether a change of the speed scale keeps the limits.

    Args:
        trajectory: A trajectory whose speed scale changes first and stays then.
        changing: Time for which it changes [s].
        speed_scale: Speed scale then; there the kinematic limits are kept anyway.
        model: The arm with its payload.
    """
    limits, times = model.limits, sample_times(min(changing, trajectory.duration), CONTROL_STEP)
    samples = trajectory.sample(times)
    use = limits.use(*samples)._replace(position=0.0)
    s_dots = trajectory.time_scaling.sample(times)[1]
    backwards = s_dots.min() < 0.0
    if limits.limits_tool and s_dots.max() > OVERSHOOT * max(s_dots[0], speed_scale):
        return False
    if backwards or not use.inside or has_jump(samples, limits.jerk):
        return False
    first = np.arange(0.0, changing, EFFORT_STEP)
    rest = np.arange(changing, trajectory.duration, EFFORT_STEP / max(speed_scale, TINY))
    effort = sampled_effort_use(model, *trajectory.sample(np.concatenate([first, rest])))
    return effort <= EFFORT_FRACTION or effort <= effort_use(trajectory.nominal, model)


def _rises(
    nominal: Trajectory, s: float, speed_scale: float
) -> Iterator[tuple[TimeScaledTrajectory, float]]:
    """Yield slower and slower rises of the speed scale from rest: at last all limits are kept."""
    for time in RISE_TIMES:
        slope = speed_scale / time
        rise = profile_to_velocity((s, 0.0, 0.0), speed_scale, (2.0 * slope, 8.0 * slope / time))
        yield _then_constant(nominal, rise, speed_scale), rise.duration


def _then_constant(
    nominal: Trajectory, change: MotionProfile, speed_scale: float
) -> TimeScaledTrajectory:
    """Return a change of the speed scale, continued to the end of a trajectory."""
    segments, duration, end = change.segments, change.duration, change.end
    if end < nominal.duration:
        segments = [*segments, [duration, end, speed_scale, 0.0, 0.0]]
        duration, end = duration + (nominal.duration - end) / speed_scale, nominal.duration
    return TimeScaledTrajectory(nominal, MotionProfile(segments, duration, end))


def _changes(
    nominal: Trajectory, state: ScalarState, speed_scale: float, model: RobotModel
) -> Iterator[tuple[TimeScaledTrajectory, float]]:
    """Yield changes that use `LIMIT_FRACTIONS` of the limits, and their durations [s]."""
    s, s_dot, _ = state
    path = np.linspace(s, nominal.duration, POINTS)
    q, v, a = nominal.sample(path)
    mass, coriolis, damping, gravity, _ = PathDynamics.along(model, q, v, a)
    free = EFFORT_FRACTION * model.limits.effort - model.friction - np.abs(damping)
    bound = np.broadcast_to(model.limits.acceleration, v.shape)
    # -below <= factors u + squares s_dot^2 <= above
    factors, squares = np.hstack([v, mass]), np.hstack([a, coriolis])
    above, below = np.hstack([bound, free - gravity]), np.hstack([bound, free + gravity])
    for margin in LIMIT_FRACTIONS:
        speeds = _forward_pass(
            factors, squares, margin * above, margin * below, path, s_dot, speed_scale, margin
        )
        change = _smoothed(path, speeds, state)
        yield _then_constant(nominal, change, speed_scale), change.duration


def _forward_pass(
    factors: np.ndarray,
    squares: np.ndarray,
    above: np.ndarray,
    below: np.ndarray,
    path: np.ndarray,
    s_dot: float,
    speed_scale: float,
    margin: float,
) -> np.ndarray:
    """Return the speed scale at points of a trajectory, changed as fast as the limits allow."""
    speeds = np.full(len(path), speed_scale)
    sign = 1.0 if speed_scale > s_dot else -1.0
    step = path[1] - path[0]
    moves = np.abs(factors) > TINY
    divisor = np.where(moves, factors, 1.0)
    x = s_dot * s_dot
    for i in range(len(path)):
        speeds[i] = np.sqrt(x)
        if sign * (speed_scale - speeds[i]) <= 0.0:
            speeds[i:] = speed_scale
            break
        low = (-below[i] - squares[i] * x) / divisor[i]
        high = (above[i] - squares[i] * x) / divisor[i]
        bound = np.maximum(low, high) if sign > 0.0 else np.minimum(low, high)
        u = float((sign * bound)[moves[i]].min(initial=MAX_S_DDOT))
        x = max(0.0, x + sign * 2.0 * step * float(np.clip(margin * u, 0.0, MAX_S_DDOT)))
    return speeds


def _smoothed(path: np.ndarray, speeds: np.ndarray, state: ScalarState) -> MotionProfile:
    """Return a profile of s with s_ddot averaged over two steps and linear in between."""
    s, s_dot, s_ddot = state
    last = int((speeds != speeds[-1]).sum())  # constant from there on
    middle = np.maximum(0.5 * (speeds[1 : last + 1] + speeds[:last]), 1e-4)
    t = np.concatenate([[0.0], np.cumsum(np.diff(path[: last + 1]) / middle)])
    step = max(SMOOTHING_STEP, t[-1] / MAX_CHANGE_STEPS)
    n = int(np.ceil(t[-1] / step)) + 2
    times = step * np.arange(-2, n + 3)
    scales = np.interp(times, t, speeds[: last + 1])
    scales[times < 0.0] = s_dot + s_ddot * times[times < 0.0]
    u = np.zeros(n + 3)
    u[1:-1] = (scales[3:-1] - scales[1:-3]) / (2.0 * step)
    u[0] = s_ddot
    # The error of the whole change by the averaging is corrected, so that it ends at the speed.
    wanted = float(scales[-1]) - s_dot - 0.5 * step * s_ddot
    got = float(step * u[1:].sum())
    if abs(wanted - got) < _SMALL_CORRECTION * abs(got):
        u[1:] *= wanted / got
    else:  # most of it comes from the initial s_ddot
        hat = np.minimum(np.arange(n + 3), np.arange(n + 3)[::-1])
        u[1:] += (wanted - got) / (step * hat.sum()) * hat[1:]
    rows = integrate_acceleration((s, s_dot, s_ddot), step * np.arange(n + 3), u)
    return MotionProfile(rows[:-1].tolist(), float(rows[-1, 0]), float(rows[-1, 1]))
