"""Paths in joint space over the path parameter s from 0 to 1."""

from functools import lru_cache
from math import factorial
from typing import Any, Protocol

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

DEGREE = 5  # of splines: their third derivatives, and with them the jerk, are smooth


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
        breakpoints, powers = _unit_splines(len(self.knots))
        polynomials = PPoly(powers @ self.knots, breakpoints)
        self._derivatives = [polynomials, polynomials.derivative(1), polynomials.derivative(2)]

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Return all coordinates and their derivatives by s up to an order."""  # (n, m) each
        return [derivative(s) for derivative in self._derivatives[: order + 1]]

    def get_state(self) -> dict[str, Any]:
        """Return the path as plain data."""
        return {"kind": "spline", "knots": self.knots.tolist(), "nq": self.nq}


@lru_cache(maxsize=8)
def _unit_splines(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return breakpoints and powers (highest first) of the splines through n unit vectors.

    A spline is linear in its knots, so these are computed once for each number of knots.
    """  # (k + 1,), (DEGREE + 1, k, n)
    spline = make_interp_spline(np.linspace(0.0, 1.0, n), np.eye(n), k=DEGREE)
    breakpoints = spline.t[DEGREE:-DEGREE]
    orders = range(DEGREE, -1, -1)
    powers = [spline(breakpoints[:-1], order) / factorial(order) for order in orders]
    return breakpoints, np.array(powers)


def path_from_state(state: dict[str, Any]) -> Path:
    """Restore a path from plain data."""
    if state["kind"] == "straight":
        return StraightPath(np.array(state["start"]), np.array(state["end"]))
    return SplinePath(np.array(state["knots"]), state["nq"])
