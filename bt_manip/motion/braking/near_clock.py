"""What limits are near a clock: linear in what another clock differs from it by."""

from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from ..curve_efforts import CurveEfforts
from ..jerk_profile import JerkProfile
from .clock_limits import Curve, State

FADING = 10  # nodes, in which what the first one uses beyond the margin comes back to it
NEAR = 1e-4  # of the way to the end, for differences
TINY = 1e-12
CLOSE = 2e-7  # to the limits: what a programme leaves
APART = 1e-4  # [s] that nodes are at least


class Rows(NamedTuple):
    """Limits along a clock, linear in what another one near it differs by: ``|value| <= most``.

    Attributes:
        value: What is limited.  # (n, m)
        most: What it shall not exceed.  # (n, m)
        rates: How fast it changes with a variable, "s", "p" or "u", at nodes.  # (n,), (n, m)
        kept: Whether the limits themselves are kept.
    """

    value: np.ndarray
    most: np.ndarray
    rates: list[tuple[str, np.ndarray, np.ndarray]]
    kept: bool


class Clock:
    """Changes of the pace at some times, and what follows from them."""

    def __init__(self, state: State, t: np.ndarray, u: np.ndarray) -> None:
        """Let a clock go on.

        Args:
            state: Its reading, its pace and the pace's change.
            t: Times of nodes, from 0 on [s].  # (n,)
            u: The changes there; between them they change evenly.  # (n,)
        """
        s, p, _ = state
        h = np.diff(t)
        self.t, self.u = t, u
        self.p = p + np.concatenate([[0.0], np.cumsum(0.5 * h * (u[1:] + u[:-1]))])
        moved = h * (self.p[:-1] + h * (u[:-1] / 3.0 + u[1:] / 6.0))
        self.s = s + np.concatenate([[0.0], np.cumsum(moved)])

    def with_nodes_at(self, readings: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Add to some times those when it is at some readings, if they are not too near."""
        inside = readings[(readings > self.s[0]) & (readings < self.s[-1])]
        added = np.interp(inside, self.s, self.t)
        kept = t[np.abs(t[:, np.newaxis] - added).min(axis=1, initial=np.inf) > APART]
        ends = np.concatenate([t[:1], kept, added, t[-1:]])
        return np.unique(ends)

    def profile(self) -> JerkProfile:
        """Give it as something to drive along."""
        rows = np.column_stack([self.t, self.s, self.p, self.u])[:-1]
        rows = np.column_stack([rows, np.diff(self.u) / np.diff(self.t)])
        return JerkProfile(rows.tolist(), float(self.t[-1]), float(self.s[-1]))


class NearClock:
    """What the limits along a curve are near a clock.

    A clock can always wait, at pace 1 and without changes, since the curve itself is inside its
    limits. So what waiting uses beyond the margin counts as no more than that; but nothing may add
    to it.

    Attributes:
        state: The clock's first reading, its pace then and the pace's change.
        pace: About the greatest pace.
        curve: What the clock goes through.
    """

    def __init__(
        self, curve: Curve, state: State, model: RobotModel, allowed: float, margin: float
    ) -> None:
        """Look at a curve.

        Args:
            curve: What the clock goes through, inside its limits at pace 1.
            state: The clock's first reading, its pace then and the pace's change.
            model: The arm with its payload.
            allowed: Fraction of the limits of effort that may be used.
            margin: Fraction of all limits that shall be used at most.
        """
        self.curve, self.state = curve, state
        self._model, self._margin = model, margin
        b = curve.bounds
        self.pace = state[1] + max(0.0, state[2]) * float((b.acceleration / b.jerk).max())
        self._bound = np.concatenate([b.acceleration, allowed * model.limits.effort, b.velocity])

    def roughly(self, clock: Clock) -> list[Rows]:
        """Limit what moves at nodes, and what accelerations change by between them."""
        nodes = self._nodes(clock)
        m = len(self.curve.bounds.jerk)
        change = np.diff(nodes.value[:, :m], axis=0)
        most = self._margin * np.diff(clock.t)[:, np.newaxis] * self.curve.bounds.jerk
        rates = [
            (name, at[part], sign * of[part, :m])
            for part, sign in ((slice(1, None), 1.0), (slice(-1), -1.0))
            for name, at, of in nodes.rates
        ]
        between = Rows(change, most, rates, bool((np.abs(change) <= most).all()))
        return [self._behind_the_first(nodes), between]

    def closely(self, clock: Clock) -> list[Rows]:
        """Limit what moves at nodes, and the jerk where each step begins and where it ends.

        Nodes have to be at the corners of the curve.
        """
        nodes = self._nodes(clock)
        s, (d1, d2) = self._inside(clock), nodes.derivatives
        h, k = np.diff(clock.t)[:, np.newaxis], np.arange(len(s) - 1)
        d3 = np.diff(d2, axis=0) / np.maximum(np.diff(s), TINY)[:, np.newaxis]
        w = np.diff(clock.u)[:, np.newaxis] / h
        bound = self.curve.bounds.jerk
        most = np.broadcast_to(self._margin * bound, d3.shape)
        rows = [self._behind_the_first(nodes)]
        for now in (k, k + 1):
            p, u, x1, x2 = clock.p[now, np.newaxis], clock.u[now, np.newaxis], d1[now], d2[now]
            waiting = d3 * p**3
            counted = self._counted(waiting, bound)
            by_clock = x1 * w + 3.0 * x2 * p * u
            rates = [
                ("u", k + 1, x1 / h),
                ("u", k, -x1 / h),
                ("u", now, 3.0 * x2 * p),
                ("p", now, 3.0 * x2 * u + np.where(waiting == counted, 3.0 * d3 * p * p, 0.0)),
                ("s", now, x2 * w + 3.0 * d3 * p * u),
            ]
            kept = np.abs(by_clock + waiting) <= (1.0 + CLOSE) * bound
            rows.append(Rows(by_clock + counted, most, rates, bool(kept.all())))
            full = nodes.full[:-1]
            if now is k and full.any():  # nor may it begin to grow within the step
                only = [(name, at, np.abs(full) * of) for name, at, of in rates]
                rows.append(Rows(full * most + np.abs(full) * by_clock, most, only, True))
        return rows

    def _nodes(self, clock: Clock) -> "_Nodes":
        """Give accelerations, efforts and velocities at the nodes."""
        s, near = self._inside(clock), NEAR * self.curve.end
        p, u = clock.p[:, np.newaxis], clock.u[:, np.newaxis]
        rate, square, linear, rest = self._parts(s)
        waiting = square * p * p + linear * p + rest
        counted = self._counted(waiting, self._bound)
        value = rate * u + counted
        rate_there, *there = self._parts(s + near)
        waiting_there = there[0] * p * p + there[1] * p + there[2]
        moved = rate_there * u + self._counted(waiting_there, self._bound) - value
        k, m = np.arange(len(s)), len(self.curve.bounds.jerk)
        by_pace = np.where(waiting == counted, 2.0 * square * p + linear, 0.0)
        full = np.where(waiting == counted, 0.0, np.sign(waiting))[:, :m]
        rates = [("u", k, rate), ("p", k, by_pace), ("s", k, moved / near)]
        derivatives = rate[:, :m], square[:, :m]
        return _Nodes(value, rate * u + waiting, full, derivatives, rates)

    def _behind_the_first(self, nodes: "_Nodes") -> Rows:
        """Limit what is used at nodes; what is used where the clock begins cannot be helped."""
        most = self._margin * self._bound
        fading = np.maximum(0.0, 1.0 - np.arange(1, len(nodes.value)) / FADING)[:, np.newaxis]
        most = most + np.maximum(0.0, np.abs(nodes.value[0]) - most) * fading
        bound = (1.0 + CLOSE) * np.maximum(self._bound, most)
        kept = bool((np.abs(nodes.used[1:]) <= bound).all())
        rates = [(name, at[1:], of[1:]) for name, at, of in nodes.rates]
        return Rows(nodes.value[1:], most, rates, kept)

    def _counted(self, waiting: np.ndarray, bound: np.ndarray) -> np.ndarray:
        """Give what counts of what a clock uses that waits."""
        return np.clip(waiting, -self._margin * bound, self._margin * bound)

    def _inside(self, clock: Clock) -> np.ndarray:
        return np.minimum(clock.s, self.curve.end)

    def _parts(self, s: np.ndarray) -> list[np.ndarray]:
        """Give what multiplies u, p^2, p and 1 in accelerations, efforts and velocities."""
        x, d1, d2 = self.curve.evaluate(np.minimum(s, self.curve.end))
        still = np.zeros_like(d1)
        at = CurveEfforts.along(self._model, x, d1, d2)
        efforts = (*at[:3], at.gravity + at.friction)
        parts = zip((d1, d2, still, still), efforts, (still, still, d1, still), strict=True)
        return [np.hstack(part) for part in parts]  # (n, 2 m + nq) each


class _Nodes(NamedTuple):
    """What is used at the nodes of a clock.

    Attributes:
        value: What counts.  # (n, k)
        used: All of it.  # (n, k)
        full: The sign of each acceleration of which waiting uses more than counts; else 0.
            # (n, m)
        derivatives: The first two of the curve.  # (n, m) each
        rates: How fast the value changes with each variable, at the same node.
    """

    value: np.ndarray
    used: np.ndarray
    full: np.ndarray
    derivatives: tuple[np.ndarray, np.ndarray]
    rates: list[tuple[str, np.ndarray, np.ndarray]]
