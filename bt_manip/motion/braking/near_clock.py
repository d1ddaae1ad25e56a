"""What limits are near a clock: linear in what another clock differs from it by."""

from functools import partial

import numpy as np

from bt_manip.robots import RobotModel

from ..bounds import Bounds
from ..curve_efforts import CurveEfforts
from .clock import Clock, Rates
from .clock_limits import Curve, State
from .rows import Looks, Places, Rows, chained, within

NEAR = 1e-4  # of the way to the end, for differences
TINY = 1e-12
BESIDE = 0.02  # of a step, for the third derivatives of the curve
LOOKS = 64  # within each step, for what is beyond its limits
# Of a limit, that a clock may be beyond it: less than what counts as rounding, and all that is left
# of a limit where a joint has to wait for another. A millionth there may be worth a twentieth of
# the time: the sooner a little of the pace is gone, the sooner more of it may go.
ROUNDING = 6e-7
CLOSE = 9e-7  # the same, of what is driven


class NearClock:
    """What the limits along a curve are near a clock.

    Along a motion over its own time a clock can always wait, at pace 1 and without changes: that is
    inside the limits. So what waiting uses beyond them counts as no more than they are; but
    nothing may add to it.

    Attributes:
        state: The clock's first reading, its pace then and the pace's change.
        pace: About the greatest pace.
        curve: What the clock goes through.
    """

    def __init__(self, curve: Curve, state: State, model: RobotModel, allowed: float) -> None:
        """Look at a curve.

        Args:
            curve: What the clock goes through.
            state: The clock's first reading, its pace then and the pace's change.
            model: The arm with its payload.
            allowed: Fraction of the limits of effort that may be used.
        """
        b = Bounds(*((1.0 + ROUNDING) * most for most in curve.bounds))
        self.curve, self.state, self._model = curve._replace(bounds=b), state, model
        self.pace = state[1] + max(0.0, state[2]) * float((b.acceleration / b.jerk).max())
        self._most = np.concatenate([b.acceleration, allowed * model.limits.effort, b.velocity])

    @property
    def begins_inside(self) -> bool:
        """Whether the clock is inside all limits where it begins."""
        value, _ = self._moving(*(np.array([x]) for x in self.state))
        return bool((np.abs(value[0]) <= (1.0 + CLOSE) * self._most).all())

    def roughly(self, clock: Clock) -> list[Rows]:
        """Limit what moves at nodes, and what accelerations change by between them."""
        value, by = self._moving(clock.s, clock.p, clock.u)
        m, k = len(self.curve.bounds.jerk), np.arange(len(clock.h))
        nodes: Rates = {(name, 1): rate[1:] for name, rate in by.items()}
        change: Rates = {(name, 1): rate[1:, :m] for name, rate in by.items()}
        change |= {(name, 0): -rate[:-1, :m] for name, rate in by.items()}
        most = clock.h[:, np.newaxis] * self.curve.bounds.jerk
        return [
            Rows(value[1:], self._most, k, nodes),
            Rows(np.diff(value[:, :m], axis=0), most, k, change),
        ]

    def closely(self, clock: Clock, looks: Looks, last: int) -> list[Rows]:
        """Limit what moves and the jerk at the ends of each step, and within it.

        Args:
            clock: The clock; its nodes are at the corners of the curve that it passes before the
                last stretch.
            looks: Where to look besides.
            last: Where the last stretch begins.
        """
        steps = np.arange(len(clock.h))
        unsure = steps[last:] if len(self.curve.corners) else steps[:0]
        found = within(partial(self._moving_at, clock), steps, looks.moving)
        found += within(partial(self._jerk_at, clock, last, np.minimum), steps, looks.jerk)
        if len(unsure):
            other = partial(self._jerk_at, clock, last, np.maximum)
            found += within(other, unsure, looks.jerk.since(last))
        return found

    def _moving_at(self, clock: Clock, places: Places) -> Rows:
        now = clock.within(*places)
        value, by = self._moving(now.s, now.p, now.u)
        return Rows(value, self._most, places.k, chained(by, now.rates))

    def _jerk_at(self, clock: Clock, last: int, chosen: np.ufunc, places: Places) -> Rows:
        """Limit the jerk at some places.

        In the last stretch there may be corners within steps, and what is behind them is that of
        the steps beside: of what the third derivatives may be the one that is chosen counts.
        """
        now = clock.within(*places)
        k, part = places
        around = [
            np.minimum(clock.within(k, near).s, self.curve.end)
            for near in (np.maximum(part - BESIDE, 0.0), np.minimum(part + BESIDE, 1.0))
        ]
        (_, _, before), (_, _, behind) = (self.curve.evaluate(s) for s in around)
        d3 = (behind - before) / np.maximum(around[1] - around[0], TINY)[:, np.newaxis]
        later = k >= last
        if len(self.curve.corners) and later.any():
            s = np.minimum(clock.s[last:], self.curve.end)
            _, _, d2 = self.curve.evaluate(s)
            third = np.diff(d2, axis=0) / np.maximum(np.diff(s), TINY)[:, np.newaxis]
            beside = np.vstack([third[:1], third, third[-1:]])
            third = chosen(third, chosen(beside[:-2], beside[2:]))
            d3[later] = chosen(d3[later], third[k[later] - last])
        value, by = self._jerk(d3, now.s, now.p, now.u, now.w)
        return Rows(value, self.curve.bounds.jerk, k, chained(by, now.rates), wild=True)

    def beyond(self, clock: Clock, looks: Looks) -> Looks:
        """Add to some places those within steps where the limits are exceeded."""
        steps, b = len(clock.h), self.curve.bounds
        k, part = np.repeat(np.arange(steps), LOOKS + 1), np.tile(np.arange(LOOKS + 1), steps)
        now = clock.within(k, part / LOOKS)
        p, u = now.p[:, np.newaxis], now.u[:, np.newaxis]
        _, d1, d2 = self.curve.evaluate(np.minimum(now.s, self.curve.end))
        acceleration = (d1 * u + d2 * p * p).reshape(steps, LOOKS + 1, -1)
        change = np.diff(acceleration, axis=1) * (LOOKS / clock.h)[:, np.newaxis, np.newaxis]
        most = 1.0 + CLOSE - ROUNDING
        return Looks(
            looks.moving.worst(np.abs(acceleration) / b.acceleration - most),
            looks.jerk.worst(np.abs(change) / b.jerk - most),
        )

    def _jerk(
        self, d3: np.ndarray, s: np.ndarray, p: np.ndarray, u: np.ndarray, w: np.ndarray
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Give the jerk, and how fast it changes."""  # (n, m) each
        _, d1, d2 = self.curve.evaluate(np.minimum(s, self.curve.end))
        p, u, w = p[:, np.newaxis], u[:, np.newaxis], w[:, np.newaxis]
        waiting, most = d3 * p**3, self.curve.bounds.jerk
        counted = self._counted(waiting, most)
        by_waiting = np.where(waiting == counted, 3.0 * d3 * p * p, 0.0)
        by = {
            "w": d1,
            "u": 3.0 * d2 * p,
            "p": 3.0 * d2 * u + by_waiting,
            "s": d2 * w + 3.0 * d3 * p * u,
        }
        return d1 * w + 3.0 * d2 * p * u + counted, by

    def _moving(
        self, s: np.ndarray, p: np.ndarray, u: np.ndarray
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Give accelerations, efforts and velocities, and how fast they change."""  # (n, k) each
        near, most = NEAR * self.curve.end, self._most
        p, u = p[:, np.newaxis], u[:, np.newaxis]
        rate, square, linear, rest = self._parts(s)
        waiting = square * p * p + linear * p + rest
        counted = self._counted(waiting, most)
        there = self._parts(s + near)
        counted_there = self._counted(there[1] * p * p + there[2] * p + there[3], most)
        moved = (there[0] - rate) * u + counted_there - counted
        by_pace = np.where(waiting == counted, 2.0 * square * p + linear, 0.0)
        return rate * u + counted, {"u": rate, "p": by_pace, "s": moved / near}

    def _counted(self, waiting: np.ndarray, most: np.ndarray) -> np.ndarray:
        """Give what counts of what a clock uses that waits."""
        return np.clip(waiting, -most, most) if self.curve.timed else waiting

    def _parts(self, s: np.ndarray) -> list[np.ndarray]:
        """Give what multiplies u, p^2, p and 1 in accelerations, efforts and velocities."""
        x, d1, d2 = self.curve.evaluate(np.minimum(s, self.curve.end))
        still = np.zeros_like(d1)
        efforts = CurveEfforts.along(self._model, x, d1, d2).by_power
        parts = zip((d1, d2, still, still), efforts, (still, still, d1, still), strict=True)
        return [np.hstack(part) for part in parts]  # (n, 2 m + nq) each
