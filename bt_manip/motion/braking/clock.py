"""A clock whose pace changes, and how what it does depends on its changes."""

from typing import NamedTuple

import numpy as np

from ..jerk_profile import JerkProfile
from .clock_limits import State

# How fast something changes with a variable of a clock: by its name, in a step or at the node where
# that begins (0) or ends (1).
Rates = dict[tuple[str, int], np.ndarray]


class Moments(NamedTuple):
    """What a clock does at some moments.

    Attributes:
        s: Its readings.  # (k,)
        p: Its paces.  # (k,)
        u: The pace's changes.  # (k,)
        w: The jerk.  # (k,)
        rates: How fast each of "s", "p", "u" and "w" changes.  # (k,) each
    """

    s: np.ndarray
    p: np.ndarray
    u: np.ndarray
    w: np.ndarray
    rates: dict[str, Rates]


class Clock:
    """Changes of the pace at some times, and what follows from them.

    Its variables are ``u``, ``p`` and ``s`` at nodes, and ``h`` and ``bow`` of the steps between.

    Attributes:
        h: The steps [s].  # (n - 1,)
        u: The changes of the pace at nodes.  # (n,)
        bow: By how much the change amid a step is above the mean of those at its ends; within a
            step it goes like a parabola.  # (n - 1,)
        t: Times of the nodes, from 0 on [s].  # (n,)
        p: Paces there.  # (n,)
        s: Readings there.  # (n,)
        mean: Of the changes within each step.  # (n - 1,)
        early: The same, weighted by how long they act until its end.  # (n - 1,)
    """

    def __init__(self, state: State, h: np.ndarray, u: np.ndarray, bow: np.ndarray) -> None:
        """Let a clock go on.

        Args:
            state: Its reading, its pace and the pace's change.
            h: The steps [s].  # (n - 1,)
            u: The changes at nodes.  # (n,)
            bow: See above.  # (n - 1,)
        """
        self.h, self.u, self.bow = h, u, bow
        self.mean, self.early = mean_changes(u, bow)
        self.t = np.concatenate([[0.0], np.cumsum(h)])
        self.p = state[1] + np.concatenate([[0.0], np.cumsum(h * self.mean)])
        moved = h * (self.p[:-1] + h * self.early)
        self.s = state[0] + np.concatenate([[0.0], np.cumsum(moved)])

    @classmethod
    def braking_all(cls, state: State, h: np.ndarray, u: np.ndarray, bow: np.ndarray) -> "Clock":
        """Make one whose changes go like some others, and which rests in the end."""
        u = u.copy()
        u[0], u[-1] = state[2], 0.0
        inner = 0.5 * float((h[1:] + h[:-1]) @ u[1:-1]) + float(h @ bow) / 1.5
        scale = -(state[1] + 0.5 * float(h[0]) * state[2]) / inner
        u[1:-1] *= scale
        return cls(state, h, u, scale * bow)

    def at(self, t: np.ndarray) -> Moments:
        """Give what it does at some times [s], the last one at the most."""
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.h) - 1)
        return self.within(k, (t - self.t[k]) / self.h[k])

    def within(self, k: np.ndarray, part: np.ndarray) -> Moments:
        """Give what it does within steps.

        Args:
            k: The steps.  # (n,)
            part: Of each that is over, 0 to 1.  # (n,)
        """
        h, bow, x = self.h[k], self.bow[k], part
        before, behind = self.u[k], self.u[k + 1]
        square, cube, up, along = (
            x * x / 2.0,
            x**3 / 6.0,
            4.0 * x * (1.0 - x),
            4.0 * (1.0 - 2.0 * x),
        )
        bulge, bulged = 4.0 * (square - 2.0 * cube), 4.0 * cube - x**4 / 3.0
        gained = (x - square) * before + square * behind + bulge * bow
        moved = (square - cube) * before + cube * behind + bulged * bow
        w = (behind - before + along * bow) / h
        one = np.ones(len(k))
        rates: dict[str, Rates] = {
            "u": {("u", 0): 1.0 - x, ("u", 1): x, ("bow", 0): up},
            "p": {
                ("p", 0): one,
                ("u", 0): h * (x - square),
                ("u", 1): h * square,
                ("bow", 0): h * bulge,
                ("h", 0): gained,
            },
            "s": {
                ("s", 0): one,
                ("p", 0): h * x,
                ("u", 0): h * h * (square - cube),
                ("u", 1): h * h * cube,
                ("bow", 0): h * h * bulged,
                ("h", 0): x * self.p[k] + 2.0 * h * moved,
            },
            "w": {
                ("u", 0): -one / h,
                ("u", 1): one / h,
                ("bow", 0): along / h,
                ("h", 0): -w / h,
            },
        }
        return Moments(
            s=self.s[k] + h * (x * self.p[k] + h * moved),
            p=self.p[k] + h * gained,
            u=(1.0 - x) * before + x * behind + up * bow,
            w=w,
            rates=rates,
        )

    def profile(self) -> JerkProfile:
        """Give it as something to drive along."""
        jerk, snap = (np.diff(self.u) + 4.0 * self.bow) / self.h, -8.0 * self.bow / self.h**2
        rows = np.column_stack([self.t[:-1], self.s[:-1], self.p[:-1], self.u[:-1], jerk, snap])
        return JerkProfile(rows.tolist(), float(self.t[-1]), float(self.s[-1]))


def mean_changes(u: np.ndarray, bow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give the means of changes within steps, and those weighted by the time until their end.

    What is gained in a step of length h is h times the first; what is moved is h times the pace at
    its beginning, and h squared times the second.
    """
    return 0.5 * (u[1:] + u[:-1]) + bow / 1.5, u[:-1] / 3.0 + u[1:] / 6.0 + bow / 3.0
