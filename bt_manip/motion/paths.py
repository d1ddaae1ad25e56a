"""Curves in joint space, over a parameter s from 0 to 1."""

from typing import Any, Protocol

import numpy as np

from .uniform_spline import UniformSpline


class Path(Protocol):
    """A curve q(s)."""

    end: np.ndarray  # (nq,)

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Give q and its first derivatives with respect to s, up to an order."""  # (n, nq) each

    def get_state(self) -> dict[str, Any]:
        """Give the path as plain data."""


class StraightPath:
    """The straight line between two configurations."""

    def __init__(self, start: np.ndarray, end: np.ndarray) -> None:
        """Connect two configurations."""
        self.start, self.end = np.array(start), np.array(end)
        self.direction = self.end - self.start

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Give q and its first derivatives with respect to s."""
        zeros = np.zeros((len(s), len(self.end)))
        along = self.start + np.outer(s, self.direction)
        return [along, zeros + self.direction, zeros, zeros][: order + 1]

    def get_state(self) -> dict[str, Any]:
        """Give the path as plain data."""
        return {"kind": "straight", "start": self.start.tolist(), "end": self.end.tolist()}


class SplinePath:
    """A spline through configurations at equal steps of s: its jerk is continuous."""

    def __init__(self, knots: np.ndarray) -> None:
        """Interpolate.

        Args:
            knots: At least seven configurations.  # (n, nq)
        """
        self.knots = np.array(knots)
        self.end = self.knots[-1]
        self._spline = UniformSpline(self.knots)

    def evaluate(self, s: np.ndarray, order: int = 2) -> list[np.ndarray]:
        """Give q and its first derivatives with respect to s."""
        return self._spline(s, order)

    def get_state(self) -> dict[str, Any]:
        """Give the path as plain data."""
        return {"kind": "spline", "knots": self.knots.tolist()}


def path_from_state(state: dict[str, Any]) -> Path:
    """Make a path from plain data."""
    if state["kind"] == "straight":
        return StraightPath(np.array(state["start"]), np.array(state["end"]))
    return SplinePath(np.array(state["knots"]))
