"""Time-optimal profiles of a path, smoothed to keep jerk limits.

TOPP-RA knows no jerk limits: the path acceleration of its result jumps. It is averaged over a few
milliseconds, or over as long as the jerk limits require. Where the averaging, or a bend between two
grid points, exceeds a limit, the constraints there are tightened by the excess.
"""

from copy import copy

import numpy as np

from bt_manip.robots import CONTROL_STEP, RobotModel

from .limit_check import EFFORT_FRACTION, effort_times, motor_efforts
from .motion_profile import MotionProfile, integrate_acceleration
from .path_constraints import PathConstraints
from .path_limits import TINY, PathLimits
from .paths import Path
from .reachability import time_optimal_velocities
from .trajectory import PathTrajectory, sample_times

TOPP_GRIDS = (120, 360)  # intervals of the grid; the finer one for bends the first cannot resolve
MIN_SMOOTHING_STEP = 6e-3  # [s] path acceleration is averaged over two steps, linear in between
SMOOTHING = (0.5, 1.0, 1.7)  # steps, in the time a joint's acceleration takes to its limit
MAX_TIMING_STEPS = 250  # of a profile, which bounds its size
AIM = 0.999  # fraction of a limit to which an excess is corrected
DAMPING_ITERATIONS = 8  # for the velocity at which damping is evaluated, where not negligible


class TimeOptimalParameterization:
    """The time-optimal profile from rest at s = 0 to rest at s = 1 on a uniform grid.

    Args:
        path: The path.
        limits: Limits of its coordinates.
        model: The arm with its payload; None ignores efforts.
        grid: Number of intervals.

    Attributes:
        smoothing_steps: Steps to smooth with [s], from the fastest to the smoothest profile.

    Raises:
        MotionError: When the arm cannot even hold itself on the path.
    """

    def __init__(
        self,
        path: Path,
        limits: PathLimits,
        model: RobotModel | None,
        grid: int,
    ) -> None:
        self._path, self._limits, self._model = path, limits, model
        ramp = float((limits.acceleration / limits.jerk)[: path.nq].max())
        self.smoothing_steps = sorted({max(MIN_SMOOTHING_STEP, part * ramp) for part in SMOOTHING})
        self._s = np.linspace(0.0, 1.0, grid + 1)
        self._constraints = PathConstraints(path, self._s, limits, model)
        self._share = np.ones((2, *self._constraints.a.shape))  # of the bounds above and below
        self._max_x = self._constraints.max_s_dot**2
        self._damping_s_dot = 0.5 * self._constraints.max_s_dot
        self._s_dot = self._solve(DAMPING_ITERATIONS)

    def profile(self, step: float) -> MotionProfile:
        """Return the profile of s, its acceleration averaged over two steps [s]."""
        return _smoothed(self._s, self._s_dot, step)

    def tightened(self, profile: MotionProfile) -> "TimeOptimalParameterization":
        """Return a parameterization with tighter constraints where a profile exceeds limits."""
        trajectory = PathTrajectory(self._path, profile)
        times = sample_times(profile.duration, CONTROL_STEP)
        s, s_dot, _ = profile.sample(times)
        reached = np.interp(self._s, s, times)
        # Smoothing spreads the acceleration of a point over a step before and a step after it.
        step = profile.duration / (len(profile.breakpoints()) - 1)
        span = (
            np.minimum(reached - step, np.append(0.0, reached[:-1])),
            np.maximum(reached + step, np.append(reached[1:], np.inf)),
        )
        x, v, a = trajectory.sample_coordinates(times)
        excess = [_max_in_spans(_excess(a, AIM * self._limits.acceleration), times, *span)]
        if self._model is not None:
            instants = effort_times(trajectory)
            tau = motor_efforts(self._model, *trajectory.sample(instants))
            effort = AIM * EFFORT_FRACTION * self._model.limits.effort
            excess.append(_max_in_spans(_excess(tau, effort), instants, *span))
        jerk = np.abs(np.diff(a, axis=0, prepend=a[:1])) / CONTROL_STEP
        uses = [np.abs(speed / limit) for _, speed, limit in self._limits.speeds(x, v)]
        use = np.hstack([*uses, np.cbrt(jerk / self._limits.jerk)])
        use = _max_in_spans(use, times, *span).max(axis=-1)
        slower = (np.interp(self._s, s, s_dot) / np.maximum(use, 1.0)) ** 2
        other = copy(self)
        bounds = self._bounds()
        other._share = self._share * bounds / (bounds + np.concatenate(excess, axis=-1))
        other._max_x = np.where(use > 1.0, np.minimum(self._max_x, slower), self._max_x)
        other._s_dot = other._solve(1)
        return other

    def _bounds(self) -> np.ndarray:
        """Return the bounds above and below."""  # (2, n, k)
        return np.maximum(self._share * self._constraints.bounds(self._damping_s_dot), TINY)

    def _solve(self, iterations: int) -> np.ndarray:
        """Return the greatest s_dot, with the damping at that of the previous iteration."""  # (n,)
        constraints = self._constraints
        for _ in range(iterations if constraints.damped else 1):
            above, below = self._bounds()
            x = time_optimal_velocities(constraints.a, constraints.b, above, below, self._max_x)
            s_dot = np.sqrt(x)
            self._damping_s_dot = 0.5 * (self._damping_s_dot + s_dot)
        return s_dot


def _excess(values: np.ndarray, limit: np.ndarray) -> np.ndarray:
    """Return by how much values are above a limit, and below its negative."""  # (2, n, m)
    return np.maximum(np.stack([values - limit, -values - limit]), 0.0)


def _max_in_spans(
    values: np.ndarray, times: np.ndarray, first: np.ndarray, last: np.ndarray
) -> np.ndarray:
    """Return the maximum of sampled values in time spans, their neighbours included.

    Args:
        values: Values at the times.  # (..., n, m)
        times: Sampling times.  # (n,)
        first: Starts of the spans.  # (k,)
        last: Ends of the spans.  # (k,)
    """  # (..., k, m)
    begin = np.maximum(times.searchsorted(first, side="right") - 1, 0)
    end = np.minimum(times.searchsorted(last) + 1, len(times))
    padded = np.concatenate([values, np.zeros_like(values[..., :1, :])], axis=-2)
    spans = np.column_stack([begin, end]).ravel()
    return np.maximum.reduceat(padded, spans, axis=-2)[..., ::2, :]


def _smoothed(s: np.ndarray, s_dot: np.ndarray, step: float) -> MotionProfile:
    """Return the profile with its acceleration averaged over two steps and linear in between."""
    intervals = 2.0 * np.diff(s) / np.maximum(s_dot[1:] + s_dot[:-1], TINY)
    t = np.concatenate([[0.0], np.cumsum(intervals)])
    n = int(np.ceil(t[-1] / max(step, t[-1] / MAX_TIMING_STEPS)))
    n = max(2, n)  # at least one in the middle
    step = t[-1] / n
    times = step * np.arange(-2, n + 3)
    v = np.interp(times, t, s_dot, left=0.0, right=0.0)  # linear in time between grid points
    a = np.zeros(n + 3)
    a[1:-1] = (v[3:-1] - v[1:-3]) / (2.0 * step)
    rows = integrate_acceleration((0.0, 0.0, 0.0), step * np.arange(n + 3), a)
    rows[:, 1:] /= rows[-1, 1]
    return MotionProfile(rows[:-1].tolist(), rows[-1, 0], 1.0)
