"""Limits along a clock, linear in what another clock differs from it by, and where they hold."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .clock import Rates


class Rows(NamedTuple):
    """Limits along a clock, linear in what another one near it differs by: ``|value| <= most``.

    Attributes:
        value: What is limited.  # (n, m)
        most: What it shall not exceed.  # (n, m) or (m,)
        at: Steps that rates are at.  # (n,)
        rates: How fast the values change.  # (n, m) each
        wild: Whether what is at one side of its range may come to the other at once.
    """

    value: np.ndarray
    most: np.ndarray
    at: np.ndarray
    rates: Rates
    wild: bool = False


class Places(NamedTuple):
    """Where limits are looked at.

    Attributes:
        k: Steps.  # (n,)
        part: Of each that is over, 0 to 1.  # (n,)
    """

    k: np.ndarray
    part: np.ndarray

    @classmethod
    def along(cls, k: np.ndarray, part: float) -> "Places":
        """Look at some steps when a part of them is over."""
        return cls(k, np.full(len(k), part))

    def since(self, first: int) -> "Places":
        """Give those from a step on."""
        later = self.k >= first
        return Places(self.k[later], self.part[later])

    def worst(self, excess: np.ndarray) -> "Places":
        """Add for each step and limit where it is exceeded most, if it is.

        Args:
            excess: At equal parts of each step.  # (steps, parts, m)
        """
        k, j = np.nonzero(excess.max(axis=1) > 0.0)
        part = excess[k, :, j].argmax(axis=1) / (excess.shape[1] - 1)
        both = np.column_stack([self.k, self.part]), np.column_stack([k, part])
        rows = np.unique(np.vstack(both), axis=0)
        return Places(rows[:, 0].astype(int), rows[:, 1])


class Looks(NamedTuple):
    """Where a clock is looked at.

    Attributes:
        moving: For limits of acceleration, effort and velocity.
        jerk: For limits of jerk.
    """

    moving: Places
    jerk: Places

    @classmethod
    def nowhere(cls) -> "Looks":
        """Look at no places."""
        return cls(Places.along(np.arange(0), 0.0), Places.along(np.arange(0), 0.0))


def within(limited: Callable[[Places], Rows], steps: np.ndarray, more: Places) -> list[Rows]:
    """Limit something at both ends of steps, in between, and at more places.

    In between it goes about like a parabola: that is nowhere beyond the highest of its values at
    the ends and of where its tangents there meet.
    """
    first, amid, last = (limited(Places.along(steps, part)) for part in (0.0, 0.5, 1.0))
    meeting = amid._replace(
        value=2.0 * amid.value - 0.5 * (first.value + last.value),
        rates={
            name: 2.0 * rate - 0.5 * (first.rates[name] + last.rates[name])
            for name, rate in amid.rates.items()
        },
    )
    # What does not jump between steps is at the end of one what it is when the next begins.
    found = [first, meeting, last] if first.wild else [meeting, last]
    return [*found, limited(more)] if len(more.k) else found


def chained(by: dict[str, np.ndarray], rates: dict[str, Rates]) -> Rates:
    """Give how fast something changes with what a clock is made of.

    Args:
        by: How fast with its readings, paces and so on.  # (n, m) each
        rates: How fast these change.  # (n,) each
    """
    found: Rates = {}
    for name, outer in by.items():
        for variable, inner in rates[name].items():
            rate = outer * inner[:, np.newaxis]
            found[variable] = found[variable] + rate if variable in found else rate
    return found
