"""What limits let a clock do that goes along a curve.

With the pace ``p`` and its change ``u`` the coordinates of a curve x(s) move with ``x' p``,
``x'' p^2 + x' u`` and ``x''' p^3 + 3 x'' p u + x' w``, where ``w`` is the clock's jerk; the efforts
are linear in u, p^2 and p. So limits of acceleration and effort bound u from below, and those of
jerk bound w on both sides.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from .curve_efforts import CurveEfforts
from .kinematic_limits import KinematicLimits
from .motion_profile import MotionProfile

_TINY = 1e-9

State = tuple[float, float, float]  # of a clock: its reading, its pace and the pace's change
Rows = tuple[np.ndarray, np.ndarray, np.ndarray]
Evaluate = Callable[[np.ndarray], Rows]


class Curve(NamedTuple):
    """What a clock goes through.

    Attributes:
        evaluate: Gives coordinates and their first two derivatives at readings of the clock, the
            joints before all others.  # (n, m) each
        bounds: What the coordinates may do.  # (m,) each
        end: The clock's last reading.
        corners: Readings where the third derivatives jump.  # (k,)
        timed: Whether it is inside its limits at pace 1, as a motion over its own time is.
    """

    evaluate: Evaluate
    bounds: KinematicLimits
    end: float
    corners: np.ndarray = np.empty(0)
    timed: bool = True

    def driven(self, clock: MotionProfile, times: np.ndarray) -> Rows:
        """Give coordinates, velocities and accelerations at some times of a clock."""
        s, p, u = (column[:, np.newaxis] for column in clock.sample(times))
        x, d1, d2 = self.evaluate(np.minimum(s[:, 0], self.end))
        return x, d1 * p, d2 * (p * p) + d1 * u  # (n, m) each


class Rates(NamedTuple):
    """What the limits of jerk allow, at each of some nodes.

    Attributes:
        fall: The lowest jerk of the clock.
        rise: Its highest jerk.
        steepest: The greatest jerk of a clock that is about to rest.
        lowest: The lowest change of the pace at which a clock without jerk keeps the limits.
    """

    fall: np.ndarray
    rise: np.ndarray
    steepest: np.ndarray
    lowest: np.ndarray


class ClockLimits:
    """The limits along a curve, computed at equal steps as far as they are asked for.

    The curve as it was planned, at pace 1, is taken to be inside them: where it uses more than the
    fraction that is asked for, it may go on doing so, and a clock can always wait.

    Attributes:
        margin: Fraction of all limits that a clock may use.
        spacing: Between the readings that are looked at.
    """

    def __init__(
        self,
        curve: Curve,
        start: float,
        spacing: float,
        model: RobotModel | None = None,
        allowed: float = 1.0,
    ) -> None:
        """Look at a curve.

        Args:
            curve: What the clock goes through.
            start: Its first reading.
            spacing: Between the readings that are looked at.
            model: The arm with its payload; None does not look at efforts.
            allowed: Fraction of the limits of effort that may be used.
        """
        self._curve, self._start, self.spacing = curve, start, spacing
        self._model, self._allowed = model, allowed
        self._m = len(curve.bounds.jerk)
        self._last = int((curve.end - start) / spacing) + 1
        self._table = np.empty((0, 0))
        self.margin = 1.0

    def extend(self, count: int) -> bool:
        """Look as many steps ahead; False where there is nothing more of the curve."""
        done, count = len(self._table), min(count, self._last + 1)
        if count <= done:
            return False
        behind = min(done, 1)  # one node more, for the jerk before the first that is new
        places = self._start + self.spacing * np.arange(done - behind, count + 1)
        x, d1, d2 = self._curve.evaluate(np.minimum(places, self._curve.end))
        jerk = np.diff(d2, axis=0) / self.spacing
        before = jerk[:-1] if behind else np.vstack([jerk[:1], jerk[:-1]])
        after, now = jerk[behind:], slice(behind, -1)
        columns = [d1[now], d2[now], np.minimum(before, after), np.maximum(before, after)]
        if self._model is not None:
            columns += CurveEfforts.along(self._model, x[now], d1[now], d2[now]).by_power
        new = np.hstack(columns)
        self._table = np.concatenate([self._table, new]) if done else new
        return True

    def nodes(self, first: int = 0) -> np.ndarray:
        """Give what is known at the nodes from one on."""  # (n, k)
        return self._table[first:]

    def at(self, s: np.ndarray) -> np.ndarray:
        """Give what is known at readings of the clock, between the nodes linearly."""  # (n, k)
        places = (s - self._start) / self.spacing
        self.extend(int(places.max()) + 2)
        i = np.minimum(places.astype(int), len(self._table) - 2)
        part = np.minimum(places - i, 1.0)[:, np.newaxis]
        rows: np.ndarray = (1.0 - part) * self._table[i] + part * self._table[i + 1]
        return rows

    def lowest(self, rows: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Give the lowest change of the pace inside acceleration and effort, at most 0.

        Args:
            rows: What is known at n readings.  # (n, k)
            p: Paces at each of them, or the same at all.  # (n, j) or (1, j)
        """
        m = self._m
        z, p = (p * p)[:, np.newaxis, :], p[:, np.newaxis, :]
        rate, square = rows[:, :m, np.newaxis], rows[:, m : 2 * m, np.newaxis]
        low = self._below(rate, square * z, self._curve.bounds.acceleration)
        if self._model is not None:
            parts = np.split(rows[:, 4 * m :, np.newaxis], 4, axis=1)
            rate, square, linear, rest = parts
            most = self._allowed * self._model.limits.effort
            low = np.maximum(low, self._below(rate, square * z + linear * p + rest, most))
        return np.minimum(low, 0.0)  # (n, j)

    def _below(self, rate: np.ndarray, rest: np.ndarray, most: np.ndarray) -> np.ndarray:
        """Solve ``|rate u + rest| <= most`` for the lowest u of all coordinates."""
        bound = np.maximum((self.margin * most)[:, np.newaxis], np.abs(rest))
        low = -(bound + np.sign(rate) * rest) / np.maximum(np.abs(rate), _TINY)
        return np.asarray(low.max(axis=1))

    def rates(self, rows: np.ndarray, p: np.ndarray, u: np.ndarray) -> Rates:
        """Give what the limits of jerk allow, at readings, paces and changes of the pace."""
        m = self._m
        p, u = p[:, np.newaxis], u[:, np.newaxis]
        rate, square, cube = rows[:, :m], 3.0 * rows[:, m : 2 * m] * p, p**3
        low, high = rows[:, 2 * m : 3 * m] * cube, rows[:, 3 * m : 4 * m] * cube
        planned = np.maximum(np.abs(low), np.abs(high))
        most = np.maximum(self.margin * self._curve.bounds.jerk, planned)
        size, sign = np.maximum(np.abs(rate), _TINY), np.sign(rate)
        low_along, high_along = np.where(sign < 0.0, -high, low), np.where(sign < 0.0, -low, high)
        by_change = sign * square * u
        fall = (-(most + low_along + by_change) / size).max(axis=1)
        rise = ((most - high_along - by_change) / size).min(axis=1)
        room = most + np.where(square > 0.0, low, -high)  # u < 0 drives it against this side
        still = -(np.maximum(room, 0.0) / np.maximum(np.abs(square), _TINY)).min(axis=1)
        return Rates(fall, rise, (most / size).min(axis=1), still)
