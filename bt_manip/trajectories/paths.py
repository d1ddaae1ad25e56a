"""Curves in joint space, over a parameter s from 0 to 1."""

from typing import Any, Protocol

import numpy as np

from .uniform_spline import UniformSpline


class Path(Protocol):
    """A curve q(s); behind the joints it may carry further coordinates that have limits."""

    nq: int  # number of joints
    end: np.ndarray  # (nq,)

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Give all coordinates and their derivatives up to an order."""  # (n, m >= nq) each

    def get_state(self) -> dict[str, Any]:
        """Give the path as plain data."""


class StraightPath:
    """The straight line between two configurations."""

    def __init__(self, start: np.ndarray, end: np.ndarray) -> None:
        """Connect two configurations."""
        self.start, self.end = np.array(start), np.array(end)
        self.nq = len(self.end)
        self.direction = self.end - self.start

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Give q and its derivatives with respect to s."""
        zeros = np.zeros((len(s), self.nq))
        along = self.start + np.outer(s, self.direction)
        return [along, zeros + self.direction, zeros, zeros][: order + 1]

    def get_state(self) -> dict[str, Any]:
        """Give the path as plain data."""
        return {"kind": "straight", "start": self.start.tolist(), "end": self.end.tolist()}


class SplinePath:
    """A spline through configurations at equal steps of s: its jerk is continuous."""

    def __init__(self, knots: np.ndarray, nq: int | None = None) -> None:
        """Interpolate.

        Args:
            knots: At least seven configurations, with further coordinates behind.  # (n, m)
            nq: Number of joints; by default there is nothing behind them.
        """
        self.knots = np.array(knots)
        self.nq = self.knots.shape[1] if nq is None else nq
        self.end = self.knots[-1, : self.nq]
        self._spline = UniformSpline(self.knots)

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Give all coordinates and their derivatives with respect to s."""
        return self._spline(s, order)

    def get_state(self) -> dict[str, Any]:
        """Give the path as plain data."""
        return {"kind": "spline", "knots": self.knots.tolist(), "nq": self.nq}


def path_from_state(state: dict[str, Any]) -> Path:
    """Make a path from plain data."""
    if state["kind"] == "straight":
        return StraightPath(np.array(state["start"]), np.array(state["end"]))
    return SplinePath(np.array(state["knots"]), state["nq"])
