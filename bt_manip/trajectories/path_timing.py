"""The fastest way to drive a path.

Time-optimal path parametrisation by reachability knows no limits of jerk: the acceleration of its
result jumps. It is averaged over a few milliseconds, or over as many as the limits of jerk ask for.
Where that, or a bend of the path, takes a plan beyond a limit, the next plan keeps off this limit
by as much more, there only.
"""

from copy import copy

import numpy as np

from bt_manip.robots import RobotModel

from .kinematic_limits import KinematicLimits
from .limit_check import CONTROL_STEP, effort_times, efforts, sample_times
from .motion_profile import MotionProfile
from .path_limits import PathLimits
from .paths import Path
from .reachability import greatest_squares
from .trajectory import PathTrajectory

TOPP_GRIDS = (120, 360)  # intervals; the finer one for a curvature that the first is too coarse for
NODE = 6e-3  # [s] acceleration is linear between nodes, and averaged over two of these, at least
RAMPS = (0.5, 1.0, 1.7)  # nodes, in the time in which a joint's full acceleration can come
MOST_NODES = 250
AIM = 0.999  # of the limits, where a plan was beyond them
ROUNDS = 8  # of the speed that damping is taken at, where it takes more than a little
_TINY = 1e-9


class PathTiming:
    """The fastest ways from rest at 0 to rest at 1 on a path that is looked at in equal steps.

    Attributes:
        nodes: What plans are smoothed over, from the fastest plan to the smoothest [s].
    """

    def __init__(
        self,
        path: Path,
        bounds: KinematicLimits,
        model: RobotModel | None,
        allowed: float,
        grid: int,
    ) -> None:
        """Look at a path.

        Args:
            path: The curve.
            bounds: Limits of its coordinates.
            model: The arm with its payload; None does not mind efforts.
            allowed: Fraction of every effort limit that may be used.
            grid: Number of steps.

        Raises:
            MotionError: When the arm cannot even stand on the path.
        """
        self._path, self._bounds, self._model, self._allowed = path, bounds, model, allowed
        ramp = float((bounds.acceleration / bounds.jerk)[: path.nq].max())
        self.nodes = sorted({max(NODE, part * ramp) for part in RAMPS})
        self._places = np.linspace(0.0, 1.0, grid + 1)
        self._limits = PathLimits(path, self._places, bounds, model, allowed)
        self._share = np.ones((2, *self._limits.rates.shape))  # of what the limits leave
        self._most = self._limits.fastest**2
        self._damped = 0.5 * self._limits.fastest
        self._speed = self._find_speed(ROUNDS)

    def plan(self, node: float) -> MotionProfile:
        """Plan, the acceleration averaged over twice a time [s]."""
        return _smoothed(self._places, self._speed, node)

    def keeping_off(self, plan: MotionProfile) -> "PathTiming":
        """Give a timing that keeps farther from the limits where a plan is beyond them."""
        driven = PathTrajectory(self._path, plan, self._bounds)
        times = sample_times(plan.duration, CONTROL_STEP)
        s, pace, _ = plan.sample(times)
        reached = np.interp(self._places, s, times)
        # What a plan does at a place it has begun to do a node before, and goes on for another.
        node = plan.duration / (len(plan.breakpoints()) - 1)
        around = (
            np.minimum(reached - node, np.append(0.0, reached[:-1])),
            np.maximum(reached + node, np.append(reached[1:], np.inf)),
        )
        _, v, a = driven.sample_coordinates(times)
        beyond = [_greatest(_beyond(a, AIM * self._bounds.acceleration), times, *around)]
        if self._model is not None:
            corners = effort_times(driven)
            tau = efforts(self._model, *driven.sample(corners))
            most = AIM * self._allowed * self._model.limits.effort
            beyond.append(_greatest(_beyond(tau, most), corners, *around))
        jerk = np.abs(np.diff(a, axis=0, prepend=a[:1])) / CONTROL_STEP
        used = np.hstack([np.abs(v) / self._bounds.velocity, np.cbrt(jerk / self._bounds.jerk)])
        used = _greatest(used, times, *around).max(axis=-1)
        slower = (np.interp(self._places, s, pace) / np.maximum(used, 1.0)) ** 2
        other = copy(self)
        left = self._left()
        other._share = self._share * left / (left + np.concatenate(beyond, axis=-1))
        other._most = np.where(used > 1.0, np.minimum(self._most, slower), self._most)
        other._speed = other._find_speed(1)
        return other

    def _left(self) -> np.ndarray:
        """Give what is left above and below."""  # (2, n, k)
        return np.maximum(self._share * self._limits.constants(self._damped), _TINY)

    def _find_speed(self, rounds: int) -> np.ndarray:
        """Give the greatest speed, damping taken at the one before, again and again."""  # (n,)
        limits = self._limits
        for _ in range(rounds if limits.damped else 1):
            above, below = self._left()
            z = greatest_squares(limits.rates, limits.squares, above, below, self._most)
            speed = np.sqrt(z)
            self._damped = 0.5 * (self._damped + speed)
        return speed


def _beyond(values: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Give by how much values are above a limit, and how much below its negative."""  # (2, n, m)
    return np.maximum(np.stack([values - most, -values - most]), 0.0)


def _greatest(
    values: np.ndarray, times: np.ndarray, first: np.ndarray, last: np.ndarray
) -> np.ndarray:
    """Give the greatest of what is known at some times, the ones next to each span included.

    Args:
        values: What is known.  # (..., n, m)
        times: When.  # (n,)
        first: When each span begins.  # (k,)
        last: When it ends.  # (k,)
    """  # (..., k, m)
    begin = np.maximum(times.searchsorted(first, side="right") - 1, 0)
    end = np.minimum(times.searchsorted(last) + 1, len(times))
    padded = np.concatenate([values, np.zeros_like(values[..., :1, :])], axis=-2)
    spans = np.column_stack([begin, end]).ravel()
    return np.maximum.reduceat(padded, spans, axis=-2)[..., ::2, :]


def _smoothed(s: np.ndarray, speed: np.ndarray, node: float) -> MotionProfile:
    """Average the acceleration over two nodes and make it linear between them."""
    steps = 2.0 * np.diff(s) / np.maximum(speed[1:] + speed[:-1], _TINY)
    t = np.concatenate([[0.0], np.cumsum(steps)])
    node = max(node, t[-1] / MOST_NODES)
    n = max(2, int(np.ceil(t[-1] / node)))  # one in the middle at least
    node = t[-1] / n
    nodes = node * np.arange(-2, n + 3)
    v = np.interp(nodes, t, speed, left=0.0, right=0.0)  # speed is linear in time between points
    a = np.zeros(n + 3)
    a[1:-1] = (v[3:-1] - v[1:-3]) / (2.0 * node)
    jerk = np.diff(a) / node
    velocity = np.concatenate([[0.0], np.cumsum(node * (a[1:] + a[:-1]) / 2.0)])
    moved = node * (velocity[:-1] + node * (a[:-1] / 2.0 + node * jerk / 6.0))
    position = np.concatenate([[0.0], np.cumsum(moved)])
    rows = np.column_stack(
        [
            node * np.arange(n + 2),
            np.column_stack([position[:-1], velocity[:-1], a[:-1], jerk]) / position[-1],
        ]
    )
    return MotionProfile(rows.tolist(), node * (n + 2), 1.0)
