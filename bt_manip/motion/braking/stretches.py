"""What a clock passes between corners of a curve, and how long it takes for each."""

from typing import NamedTuple

import numpy as np

from .clock import Clock, mean_changes
from .clock_limits import Curve, State

PASSED = 0.1  # of the greatest pace: corners that are passed slower than that hardly matter
APART = 1e-6  # [s] that corners are at least
LOOKS = 2000  # at a clock, to see when it passes them


class Stretches(NamedTuple):
    """Stretches of time from corner to corner; at the end of the last one the clock rests.

    Within a stretch the steps keep their ratios, and how long it takes follows from the changes of
    the pace: so corners are always at the same nodes.

    Attributes:
        corners: Readings between two stretches.  # (k,)
        first: The first step of each stretch, and the number of all steps.  # (k + 2,)
    """

    corners: np.ndarray
    first: np.ndarray

    @property
    def last(self) -> int:
        """Where the last stretch begins."""
        return int(self.first[-2])

    @property
    def at_corners(self) -> np.ndarray:
        """Which nodes are at corners."""  # (k,)
        return self.first[1:-1]

    @property
    def inner(self) -> np.ndarray:
        """Which steps have their predecessor in the same stretch."""
        return np.setdiff1d(np.arange(self.first[-1]), self.first[:-1])

    def fits(self, curve: Curve, clock: Clock, pace: float) -> bool:
        """Tell whether a clock passes all these corners, and quickly no other one."""
        some, _ = corners_passed(curve, clock, 2.0 * PASSED * pace)
        many, _ = corners_passed(curve, clock, 0.5 * PASSED * pace)
        return set(some) <= set(self.corners) <= set(many)

    def paced(self, state: State, h: np.ndarray, u: np.ndarray, bow: np.ndarray) -> Clock | None:
        """Make a clock that passes the corners at their nodes and rests at the last one.

        Args:
            state: Where it begins.
            h: Steps that have the right ratios within each stretch [s].  # (n - 1,)
            u: Changes of the pace at nodes.  # (n,)
            bow: Of the steps.  # (n - 1,)

        Returns:
            None where it would rest before a corner, or not at all.
        """
        h, (s, p, _) = h.copy(), state
        mean, early = mean_changes(u, bow)
        for i, (a, b) in enumerate(zip(self.first, self.first[1:], strict=False)):
            steps = h[a:b]
            gained = np.concatenate([[0.0], np.cumsum(steps * mean[a:b])])
            even = p * float(steps.sum())
            bent = float(steps @ gained[:-1] + (steps * steps) @ early[a:b])
            # In a time longer by a factor c it moves by c even + c^2 bent.
            if i < len(self.corners):
                way = self.corners[i] - s
                square = even * even + 4.0 * bent * way
                if square <= 0.0:
                    return None
                factor = 2.0 * way / (even + np.sqrt(square))
            elif gained[-1] < 0.0:
                factor = -p / gained[-1]
            else:
                return None
            if factor <= 0.0:
                return None
            h[a:b] *= factor
            s += factor * (even + factor * bent)
            p += factor * gained[-1]
        return Clock(state, h, u, bow)


def corners_passed(curve: Curve, clock: Clock, slow: float) -> tuple[np.ndarray, np.ndarray]:
    """Give the corners that a clock passes, before it goes slower than a pace, and when [s]."""
    t = np.linspace(0.0, clock.t[-1], LOOKS)
    now = clock.at(t)
    end = now.s[now.p > slow].max(initial=clock.s[0])
    corners = np.unique(curve.corners)
    passed = corners[(corners > clock.s[0]) & (corners < end)]
    times = np.interp(passed, now.s, t)
    kept = np.diff(times, prepend=0.0) > APART
    return passed[kept], times[kept]


def stretched(
    curve: Curve, state: State, clock: Clock, pace: float, steps: int
) -> tuple[Stretches, Clock]:
    """Give a clock nodes at the corners that it passes.

    Args:
        curve: What it goes through.
        state: Where it begins.
        clock: The clock, which rests in the end.
        pace: About the greatest one.
        steps: About how many it shall have.
    """
    corners, times = corners_passed(curve, clock, PASSED * pace)
    for count in range(len(corners), -1, -1):  # it may be that the last ones are hardly reached
        ends = np.concatenate([[0.0], times[:count], clock.t[-1:]])
        counts = np.maximum(1, np.round(steps * np.diff(ends) / ends[-1]).astype(int))
        stretches = Stretches(corners[:count], np.concatenate([[0], np.cumsum(counts)]))
        t = np.interp(np.arange(counts.sum() + 1), stretches.first, ends)
        u, amid = clock.at(t).u, clock.at(0.5 * (t[1:] + t[:-1])).u
        u[0], u[-1] = state[2], 0.0
        bow = amid - 0.5 * (u[1:] + u[:-1])
        found = stretches.paced(state, np.diff(t), u, bow)
        if found is not None:
            return stretches, found
    return stretches, Clock.braking_all(state, np.diff(t), u, bow)
