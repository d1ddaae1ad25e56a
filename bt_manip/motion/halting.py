"""The fastest way to bring a motion to rest on its own path.

A path is gone through by a clock: its reading s, its pace p and the pace's change u, whose own
change is the clock's jerk. With the path's derivatives x' and x'' its coordinates accelerate by
``x' u + x'' p^2``, and the efforts are linear in u, p^2 and p. So in each short step the limits of
acceleration and effort leave an interval of u, the limits of jerk leave another one around the u of
the step before, and the lowest u in both brakes hardest. Once the pace is only just enough to let u
come back to nought in time, it does so at the greatest jerk.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .jerk_profile import JerkProfile

STEP = 1e-3  # [s] in which the clock's jerk is constant
MOST_STEPS = 4000
LANDING = 0.97  # of the limits of jerk, for coming back to nought
# Fractions of the limits, and the time [s] that is looked ahead for limits that become narrower.
TRIALS = (
    (0.999, 0.0), (0.99, 0.0), (0.97, 0.0), (0.999, 5e-3), (0.97, 5e-3), (0.999, 12e-3),
    (0.97, 12e-3), (0.94, 0.0), (0.9, 0.0), (0.9, 12e-3), (0.85, 0.0), (0.8, 0.0), (0.7, 0.0),
    (0.6, 0.0), (0.5, 0.0), (0.4, 0.0), (0.3, 0.0), (0.2, 0.0),
)  # fmt: skip
LOOK = 2.5e-3  # [s] between the places ahead that are looked at
_CHUNK = 64  # places whose limits are computed at once
_TINY = 1e-12

Evaluate = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]


class Curve(NamedTuple):
    """What a clock goes through.

    Attributes:
        evaluate: Gives coordinates and their first two derivatives at readings of the clock, the
            joints before all others.  # (n, m) each
        bounds: What the coordinates may do.  # (m,) each
        end: The clock's last reading.
    """

    evaluate: Evaluate
    bounds: Bounds
    end: float


def halting_clocks(
    curve: Curve, state: tuple[float, float, float], model: RobotModel, allowed: float
) -> Iterator[JerkProfile]:
    """Bring a clock to rest, braking as hard as the limits allow in each step; and less hard.

    Whether the limits are kept is for the caller to see: where they become narrower faster than the
    jerk may follow, only braking less hard helps.

    Args:
        curve: What the clock goes through.
        state: Its reading, its pace and the pace's change.
        model: The arm with its payload.
        allowed: Fraction of the limits of effort that may be used.

    Returns:
        Clocks that come to rest before the end, the fastest first.
    """
    if state[1] <= _TINY:
        return
    limits = _Limits(curve, state[0], state[1] * STEP, model, allowed)
    for margin, ahead in TRIALS:
        limits.use(margin)
        profile = _halted(limits, state, curve.end, ahead)
        if profile is not None:
            yield profile


def _halted(
    limits: "_Limits", state: tuple[float, float, float], end: float, ahead: float
) -> JerkProfile | None:
    """Go forward with the lowest change of the pace until it rests; None behind the end."""
    s, p, u = state
    segments: list[list[float]] = []
    h, t, landing = STEP, 0.0, False
    here = limits.at(s)
    while t < MOST_STEPS * h:
        steepest = LANDING * limits.steepest(here)
        if landing:
            ramp = -2.0 * p / u
            jerk = -u / ramp
            segments.append([t, s, p, u, jerk])
            s += ramp * (p + ramp * (0.5 * u + ramp * jerk / 6.0))
            return JerkProfile(segments, t + ramp, s) if s <= end else None
        there = limits.at(s + h * (p + 0.5 * h * u))
        lowest = limits.lowest(here, there, (p, u), max(0.0, p + h * u), h)
        for k in range(1, round(ahead / LOOK) + 1):
            least, _ = limits.between(limits.at(s + k * LOOK * p), p)
            lowest = max(lowest, min(least, max(u, 0.0)))
        if lowest < 0.0 and 2.0 * p + h * (u + lowest) < lowest * lowest / steepest:
            landing = True  # at this step's end the greatest jerk is just enough
            root = h * h + 4.0 * max(0.0, 2.0 * p + h * u) / steepest
            lowest = 0.5 * steepest * (h - float(np.sqrt(root)))
        jerk = (lowest - u) / h
        segments.append([t, s, p, u, jerk])
        s += h * (p + h * (0.5 * u + h * jerk / 6.0))
        p += 0.5 * h * (u + lowest)
        u = lowest
        t += h
        if s > end or p <= 0.0 or (landing and u >= 0.0):
            return None
        here = limits.at(s)
    return None


class _Limits:
    """The limits along a curve, computed where they are asked for and interpolated between."""

    def __init__(
        self,
        curve: Curve,
        start: float,
        spacing: float,
        model: RobotModel,
        allowed: float,
    ) -> None:
        self._curve, self._model, self._allowed = curve, model, allowed
        self._start, self._spacing = start, spacing
        self._rows = np.empty((0, 0))
        self._m = len(curve.bounds.jerk)
        self.use(1.0)

    def use(self, margin: float) -> None:
        """Take only a fraction of all limits from now on."""
        bounds, effort = self._curve.bounds, self._allowed * self._model.limits.effort
        self._bound = margin * np.concatenate([bounds.acceleration, effort])
        self._jerk = margin * bounds.jerk

    def at(self, s: float) -> np.ndarray:
        """Give what multiplies u, p^2, p and 1, one below the other."""  # (4, m + nq)
        place = (s - self._start) / self._spacing
        i = int(place)
        while i + 1 >= len(self._rows):
            self._extend()
        part = place - i
        rows: np.ndarray = (1.0 - part) * self._rows[i] + part * self._rows[i + 1]
        return rows

    def _extend(self) -> None:
        done = len(self._rows)
        places = self._start + self._spacing * np.arange(done, done + _CHUNK)
        x, d1, d2 = self._curve.evaluate(np.minimum(places, self._curve.end))
        model, n = self._model, self._model.nq
        still, none = np.zeros(n), np.zeros_like(d1)
        q, v, a = x[:, :n], d1[:, :n], d2[:, :n]
        gravity = np.array([model.rnea(row, still, still) for row in q])
        inertia = np.array([model.rnea(*row) for row in zip(q, 0.0 * v, v, strict=True)])
        motion = np.array([model.rnea(*row) for row in zip(q, v, a, strict=True)])
        rows = np.stack(
            [
                np.hstack([d1, inertia - gravity]),
                np.hstack([d2, motion - gravity]),
                np.hstack([none, model.damping * v]),
                np.hstack([none, gravity + model.friction * np.sign(v)]),
            ],
            axis=1,
        )
        self._rows = np.concatenate([self._rows, rows]) if done else rows

    def steepest(self, here: np.ndarray) -> float:
        """Give the greatest jerk of a clock that is about to rest."""
        return float((self._jerk / np.maximum(np.abs(here[0, : self._m]), _TINY)).min())

    def between(self, there: np.ndarray, pace: float) -> tuple[float, float]:
        """Give the change of the pace that acceleration and effort allow: from, and to."""
        moves = np.abs(there[0]) > 1e-9
        rate = np.where(moves, there[0], 1.0)
        rest = np.sign(rate) * (there[1] * (pace * pace) + there[2] * pace + there[3])
        least = np.where(moves, (-rest - self._bound) / np.abs(rate), -np.inf).max()
        most = np.where(moves, (-rest + self._bound) / np.abs(rate), np.inf).min()
        return float(least), float(most)

    def lowest(
        self,
        here: np.ndarray,
        there: np.ndarray,
        now: tuple[float, float],
        pace: float,
        step: float,
    ) -> float:
        """Give the lowest change of the pace at the end of a step."""
        p, u = now
        least, most = self.between(there, pace)
        m = self._m
        moves = np.abs(there[0, :m]) > 1e-9
        rate = np.where(moves, there[0, :m], 1.0)
        before = here[0, :m] * u + here[1, :m] * (p * p)
        to_go = np.sign(rate) * (before - there[1, :m] * (pace * pace))
        jerk = step * self._jerk
        first = np.where(moves, (to_go - jerk) / np.abs(rate), -np.inf).max()
        last = np.where(moves, (to_go + jerk) / np.abs(rate), np.inf).min()
        wanted = least if least <= most else 0.5 * (least + most)
        # Where joints brake with all they have already, the clock waits instead of going faster.
        wanted = min(wanted, max(u, 0.0))
        return float(min(max(wanted, first), last) if first <= last else 0.5 * (first + last))
