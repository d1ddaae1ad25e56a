"""Paths in joint space over the path parameter s from 0 to 1."""

from functools import lru_cache
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
        limits: Limits of velocity, acceleration and jerk of the further coordinates.  # (3, m - nq)
    """

    nq: int
    end: np.ndarray
    limits: np.ndarray

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Return coordinates and derivatives by s up to an order."""  # (n, m >= nq) each

    def get_state(self) -> dict[str, Any]:
        """Return the path as plain data."""


class StraightPath:
    """The joint-space segment between two configurations."""

    limits = np.empty((3, 0))

    def __init__(self, start: np.ndarray, end: np.ndarray) -> None:
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
    """The quintic spline through knots at equal steps of s, with not-a-knot end conditions.

    Args:
        knots: At least six configurations, each followed by any further coordinates.  # (n, m)
        nq: Number of joints; by default there are no further coordinates.
        limits: As in `Path`; by default infinite.
    """

    def __init__(
        self, knots: np.ndarray, nq: int | None = None, limits: np.ndarray | None = None
    ) -> None:
        self.knots = np.array(knots)
        self.nq = self.knots.shape[1] if nq is None else nq
        further = self.knots.shape[1] - self.nq
        self.limits = np.full((3, further), np.inf) if limits is None else limits
        self.end = self.knots[-1, : self.nq]
        self._breakpoints, splines = _unit_splines(len(self.knots))
        self._coefficients = splines @ self.knots  # (k, DEGREE + 1, m)

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Return all coordinates and their derivatives by s up to an order."""  # (n, m) each
        piece = self._breakpoints[1:-1].searchsorted(s, side="right")
        u = s - self._breakpoints[piece]
        powers = np.vander(u, DEGREE + 1, increasing=True)
        monomials = _FACTORS[: order + 1] * powers[:, _EXPONENTS[: order + 1]]
        values = monomials @ self._coefficients[piece]
        return [values[:, i] for i in range(order + 1)]

    def get_state(self) -> dict[str, Any]:
        """Return the path as plain data."""
        return {
            "kind": "spline",
            "knots": self.knots.tolist(),
            "nq": self.nq,
            "limits": self.limits.tolist(),
        }


@lru_cache(maxsize=8)
def _unit_splines(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return breakpoints and coefficients (lowest first) of the splines through n unit vectors.

    A spline is linear in its knots, so these are computed once for each number of knots. It has
    n - 5 pieces; not-a-knot: none begins at the two knots next to either end.
    """  # (n - 4,), (n - 5, DEGREE + 1, n)
    at = np.arange(float(n))
    breakpoints = np.concatenate((at[:1], at[3:-3], at[-1:]))
    weights = np.linalg.inv(_b_splines(breakpoints, at))
    # Each piece is the polynomial through DEGREE + 1 of its points.
    unit = np.linspace(0.0, 1.0, DEGREE + 1)
    width = np.diff(breakpoints)[:, None]
    points = breakpoints[:-1, None] + width * unit
    values = (_b_splines(breakpoints, points.ravel()) @ weights).reshape(*points.shape, n)
    coefficients = np.linalg.inv(unit[:, None] ** _POWERS) @ values
    step = 1.0 / (n - 1)
    return breakpoints * step, coefficients / ((width * step) ** _POWERS)[:, :, None]


def _b_splines(breakpoints: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the values of the B-splines of the breakpoints at x, by the Cox-de Boor recursion."""
    # (k + 1,), (m,) -> (m, k + DEGREE)
    t = np.pad(breakpoints, DEGREE, mode="edge")
    x = np.minimum(x, np.nextafter(t[-1], 0.0))[:, None]  # pieces are half-open
    values = ((t[:-1] <= x) & (x < t[1:])).astype(float)
    for degree in range(1, DEGREE + 1):
        widths = t[degree:] - t[:-degree]
        rising = np.divide(x - t[:-degree], widths, where=widths > 0.0, out=np.zeros(values.shape))
        values = rising[:, :-1] * values[:, :-1] + (1.0 - rising[:, 1:]) * values[:, 1:]
    return values


def path_from_state(state: dict[str, Any]) -> Path:
    """Restore a path from plain data."""
    if state["kind"] == "straight":
        return StraightPath(np.array(state["start"]), np.array(state["end"]))
    return SplinePath(np.array(state["knots"]), state["nq"], np.array(state["limits"]))
