"""The shortest time in which a motion can come to rest on its path, computed without bt-manip.

Two bounds from below, neither of which knows what bt-manip does. `alone`: no joint, and no
coordinate that the path carries, can rest sooner than it could by itself, whatever the path.
`along`: no clock along the path can rest sooner than one whose jerk is unlimited. For that one the
optimum is computed: with ``z = p^2`` and ``u = dp/dt = dz/ds / 2`` the limits are linear, so the
fastest way from the present pace to rest at a given place is found by reachability (H. Pham,
Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis",
IEEE T-RO 34 (2018)), here for all places at once; the best of them is where to rest. It may wait,
or even go faster first, where that helps.
"""

import numpy as np
import ruckig

from bt_manip.motion.braking.clock_limits import Curve
from bt_manip.robots import RobotModel

GRID = 240  # intervals, and places to rest at
FINER = 5  # times, at most, that the grid is laid over what a rest nearby needs
NEARBY = 80  # intervals: a best place nearer than that is looked at more closely
RELAXED = 1.00001  # times the limits, so that rounding rules nothing out
_TINY = 1e-12
State = tuple[float, float, float]


def shortest(curve: Curve, state: State, model: RobotModel) -> float:
    """Give the greater of both bounds: nothing rests sooner [s].

    Args:
        curve: What the clock goes through.
        state: The clock's reading, its pace and the pace's change.
        model: The arm with its payload.
    """
    return max(alone(curve, state), along(curve, state, model))


def alone(curve: Curve, state: State) -> float:
    """Give the longest time that any coordinate needs by itself, path and efforts apart [s]."""
    s, p, u = state
    _, d1, d2 = (rows[0] for rows in curve.evaluate(np.array([s])))
    v, a = d1 * p, d1 * u + d2 * p * p
    longest = 0.0
    for i in np.flatnonzero((np.abs(v) > 1e-9) | (np.abs(a) > 1e-9)):
        unit = float(curve.bounds.acceleration[i])
        asked = ruckig.InputParameter(1)
        asked.control_interface = ruckig.ControlInterface.Velocity
        asked.current_velocity = [v[i] / unit]
        asked.current_acceleration = [a[i] / unit]
        asked.max_acceleration, asked.max_jerk = [1.0], [float(curve.bounds.jerk[i]) / unit]
        answer = ruckig.Trajectory(1)
        ruckig.Ruckig(1).calculate(asked, answer)
        longest = max(longest, answer.duration)
    return longest


def along(curve: Curve, state: State, model: RobotModel) -> float:
    """Give the shortest time to rest that path, velocity, acceleration and effort leave [s].

    Damping is taken as anything between none and what it is at the greatest pace.
    """
    start, pace, _ = state
    end, least = curve.end, np.inf
    for _ in range(FINER):
        s = np.linspace(start, end, GRID + 1)
        times = _to_rest(curve, s, pace, model)
        best = int(times.argmin())
        least = float(times[best])
        if best >= NEARBY or not np.isfinite(least):
            break
        end = start + 2.0 * (float(s[best + 1]) - start)
    return least if np.isfinite(least) else 0.0


def _to_rest(curve: Curve, s: np.ndarray, pace: float, model: RobotModel) -> np.ndarray:
    """Give the shortest times from a pace at the first place to rest at each of them."""  # (n,)
    limits = _Limits(curve, s, pace, model)
    n, h = len(s), float(s[1] - s[0])
    reachable = np.zeros((n, n))  # greatest z at a place (row) for resting at another (column)
    greatest = np.zeros(n)
    for i in range(n - 2, -1, -1):
        greatest = np.minimum(limits.before(i, greatest, h), limits.most[i])
        greatest[: i + 1] = 0.0
        reachable[i] = greatest
    z, times = np.full(n, pace * pace), np.zeros(n)
    times[(reachable[0] < pace * pace)] = np.inf
    for i in range(n - 1):
        after = np.minimum(limits.after(i, z, h), reachable[i + 1])
        after = np.maximum(after, 0.0)
        step = 2.0 * h / (np.sqrt(z) + np.sqrt(after) + _TINY)
        going = np.arange(n) > i
        times = np.where(going, times + step, times)
        z = np.where(going, after, z)
    return times


class _Limits:
    """The limits at places of a path, as ``u <= slope z + offset`` or ``u >= slope z + offset``.

    Attributes:
        most: The greatest z at each place.  # (n,)
    """

    def __init__(self, curve: Curve, s: np.ndarray, pace: float, model: RobotModel):
        x, d1, d2 = curve.evaluate(np.minimum(s, curve.end))
        nq = model.nq
        q, v, a, still = x[:, :nq], d1[:, :nq], d2[:, :nq], np.zeros(nq)
        gravity = np.array([model.rnea(row, still, still) for row in q])
        inertia = np.array([model.rnea(i, still, j) for i, j in zip(q, v, strict=True)]) - gravity
        motion = np.array([model.rnea(i, j, k) for i, j, k in zip(q, v, a, strict=True)]) - gravity
        fastest = RELAXED * (curve.bounds.velocity / np.maximum(np.abs(d1), _TINY)).min(axis=1)
        fastest[0] = max(fastest[0], pace)
        damping = model.damping * v * np.minimum(fastest, 1e3 * pace)[:, np.newaxis]
        effort = RELAXED * model.limits.effort
        dry = gravity + model.friction * np.sign(v)
        room = np.broadcast_to(RELAXED * curve.bounds.acceleration, d1.shape)
        above = np.hstack([room, effort - dry - np.minimum(damping, 0.0)])
        below = np.hstack([room, effort + dry + np.maximum(damping, 0.0)])
        rates, squares = np.hstack([d1, inertia]), np.hstack([d2, motion])
        rates, squares = np.hstack([rates, -rates]), np.hstack([squares, -squares])
        constants = np.hstack([above, below])
        self._upper, self._lower = rates > _TINY, rates < -_TINY
        safe = np.where(self._upper | self._lower, rates, 1.0)
        self._slope, self._offset = -squares / safe, constants / safe
        flat = ~(self._upper | self._lower) & (squares > _TINY)
        bend = np.where(flat, constants / np.where(flat, squares, 1.0), np.inf).min(axis=1)
        self.most = self._admissible(np.minimum(fastest**2, bend))
        self.most[0] = max(self.most[0], pace * pace)

    def _admissible(self, most: np.ndarray) -> np.ndarray:
        """Lower the greatest z to where some u is still allowed, by bisection."""
        low, high, trial = np.zeros_like(most), most.copy(), most
        for _ in range(50):
            bound = self._slope * trial[:, np.newaxis] + self._offset
            least = np.where(self._lower, bound, -np.inf).max(axis=1)
            fits = least <= np.where(self._upper, bound, np.inf).min(axis=1)
            low, high = np.where(fits, trial, low), np.where(fits, high, trial)
            trial = 0.5 * (low + high)
        return low

    def before(self, i: int, after: np.ndarray, h: float) -> np.ndarray:
        """Give the greatest z at a place from which braking leads to some z at the next."""
        rise = 1.0 + 2.0 * h * self._slope[i]
        binds = self._lower[i] & (rise > _TINY)
        z = (after[:, np.newaxis] - 2.0 * h * self._offset[i, binds]) / rise[binds]
        return np.maximum(z.min(axis=1, initial=np.inf), 0.0)

    def after(self, i: int, z: np.ndarray, h: float) -> np.ndarray:
        """Give the greatest z at the next place."""
        upper = self._upper[i]
        u = self._slope[i, upper] * z[:, np.newaxis] + self._offset[i, upper]
        return z + 2.0 * h * u.min(axis=1, initial=np.inf)
