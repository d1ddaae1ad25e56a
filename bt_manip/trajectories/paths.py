"""Paths in joint space over the path parameter s from 0 to 1."""

from functools import lru_cache
from math import comb
from typing import Any, Protocol

import numpy as np

DEGREE = 5  # of splines: their third derivatives, and with them the jerk, are smooth
_POWERS = np.arange(DEGREE + 1)
_EXPONENTS = np.maximum(_POWERS - np.arange(3)[:, None], 0)
"""Exponents of the monomials of a piece and of their first and second derivative."""  # (3, 6)
_FACTORS = np.array([_POWERS**0, _POWERS, _POWERS * (_POWERS - 1)], dtype=float)
"""Their factors."""  # (3, 6)


class Path(Protocol):
    """A path q(s); the joints may be followed by further coordinates that have limits.

    Attributes:
        nq: Number of joints.
        end: Configuration at s = 1 [rad].  # (nq,)
    """

    nq: int
    end: np.ndarray

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Return coordinates and derivatives by s up to an order."""  # (n, m >= nq) each

    def get_state(self) -> dict[str, Any]:
        """Return the path as plain data."""


class StraightPath:
    """The joint-space segment between two configurations."""

    def __init__(self, start: np.ndarray, end: np.ndarray) -> None:
        """Connect two configurations."""
        self.start, self.end = np.array(start), np.array(end)
        self.nq = len(self.end)
        self.direction = self.end - self.start

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Return q and its derivatives by s up to an order."""  # (n, nq) each
        zeros = np.zeros((len(s), self.nq))
        q = self.start + np.outer(s, self.direction)
        return [q, zeros + self.direction, zeros][: order + 1]

    def get_state(self) -> dict[str, Any]:
        """Return the path as plain data."""
        return {"kind": "straight", "start": self.start.tolist(), "end": self.end.tolist()}


class SplinePath:
    """The quintic spline through knots at equal steps of s, with not-a-knot end conditions."""

    def __init__(self, knots: np.ndarray, nq: int | None = None) -> None:
        """Interpolate.

        Args:
            knots: At least six configurations, each followed by any further coordinates.  # (n, m)
            nq: Number of joints; by default there are no further coordinates.
        """
        self.knots = np.array(knots)
        self.nq = self.knots.shape[1] if nq is None else nq
        self.end = self.knots[-1, : self.nq]
        self._breakpoints, splines = _unit_splines(len(self.knots))
        self._coefficients = splines @ self.knots  # (k, DEGREE + 1, m)

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Return all coordinates and their derivatives by s up to an order."""  # (n, m) each
        piece = self._breakpoints[1:-1].searchsorted(s, side="right")
        u = s - self._breakpoints[piece]
        monomials = (_FACTORS * u[:, None, None] ** _EXPONENTS)[:, : order + 1]
        values = monomials @ self._coefficients[piece]
        return [values[:, i] for i in range(order + 1)]

    def get_state(self) -> dict[str, Any]:
        """Return the path as plain data."""
        return {"kind": "spline", "knots": self.knots.tolist(), "nq": self.nq}


@lru_cache(maxsize=8)
def _unit_splines(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return breakpoints and coefficients (lowest first) of the splines through n unit vectors.

    A spline is linear in its knots, so these are computed once for each number of knots. The
    k = n - 5 pieces interpolate the knots and have equal derivatives up to the fourth where they
    meet; not-a-knot: they do not meet at the two knots next to either end.
    """  # (k + 1,), (k, DEGREE + 1, n)
    knots = np.arange(float(n))  # at unit steps: well conditioned
    breakpoints = np.concatenate((knots[:1], knots[3:-3], knots[-1:]))
    k, m = len(breakpoints) - 1, DEGREE + 1
    equations, right = np.zeros((k * m, k, m)), np.zeros((k * m, n))
    piece = breakpoints[1:-1].searchsorted(knots, side="right")
    equations[range(n), piece] = (knots - breakpoints[piece])[:, None] ** _POWERS
    right[range(n), range(n)] = 1.0
    rows = iter(range(n, k * m))
    for i, width in enumerate(np.diff(breakpoints)[:-1]):
        for order in range(DEGREE):
            row = next(rows)
            for power in range(order, m):
                equations[row, i, power] = comb(power, order) * width ** (power - order)
            equations[row, i + 1, order] = -1.0
    coefficients = np.linalg.solve(equations.reshape(k * m, k * m), right).reshape(k, m, n)
    step = 1.0 / (n - 1)
    return breakpoints * step, coefficients / step ** _POWERS[:, None]


def path_from_state(state: dict[str, Any]) -> Path:
    """Restore a path from plain data."""
    if state["kind"] == "straight":
        return StraightPath(np.array(state["start"]), np.array(state["end"]))
    return SplinePath(np.array(state["knots"]), state["nq"])
