"""Limits of the path acceleration and the path jerk while an arm stops on its path.

With path velocity s_dot, path acceleration s_ddot and path jerk s_dddot, the coordinates x(s) of a
path have the velocity ``x' s_dot``, the acceleration ``x'' s_dot^2 + x' s_ddot`` and the jerk
``x''' s_dot^3 + 3 x'' s_dot s_ddot + x' s_dddot``. So acceleration and effort limits bound s_ddot
from below, and jerk limits bound s_dddot on both sides.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from .path_constraints import PathDynamics
from .path_limits import TINY, PathLimits

STOP_EFFORT_FRACTION = 0.98  # of every effort limit: more than for motions, so that there is some
# left to stop where a motion uses all of its own fraction
DYNAMICS_EVERY = 4  # nodes: efforts change little in between, and inverse dynamics take long


class LimitedPath(NamedTuple):
    """A path with limits: a geometric path, or a trajectory whose time is the path parameter.

    Attributes:
        evaluate: Returns coordinates and their first two derivatives by s, the joints first.
            # (n, m) each
        limits: Limits of the coordinates.
        end: Last path parameter.
    """

    evaluate: Callable[[np.ndarray], Sequence[np.ndarray]]
    limits: PathLimits
    end: float


class JerkBounds(NamedTuple):
    """Bounds from jerk limits at n nodes.

    Attributes:
        lowest: Lowest path jerk.
        highest: Highest path jerk.
        at_rest: Greatest path jerk at a path velocity and path acceleration near zero.
        constant: Lowest path acceleration that keeps the jerk limits at zero path jerk.
    """

    lowest: np.ndarray
    highest: np.ndarray
    at_rest: np.ndarray
    constant: np.ndarray


class DecelerationLimits:
    """The limits along a path at equal steps of s, evaluated as far as they are needed.

    The path at s_dot = 1 is taken to be inside its limits where s is time: where it uses more than
    the requested fraction, it may go on doing so.

    Args:
        path: The path.
        start: First path parameter.
        model: The arm with its payload; None ignores efforts.

    Attributes:
        margin: Fraction of all limits that may be used.
        spacing: Step of s.
    """

    def __init__(
        self,
        path: LimitedPath,
        start: float,
        spacing: float,
        model: RobotModel | None,
    ) -> None:
        self._path, self._start, self.spacing = path, start, spacing
        self._model = model
        self._m = len(path.limits.jerk)
        self._last = int((path.end - start) / spacing) + 1
        self._table = np.empty((0, 0))
        self.margin = 1.0

    def extend(self, count: int) -> bool:
        """Evaluate the first nodes up to a count; return False at the end of the path."""
        done, count = len(self._table), min(count, self._last + 1)
        if count <= done:
            return False
        before = min(done, 1)  # one more node, for the third derivative before the first new one
        s = self._start + self.spacing * np.arange(done - before, count + 1)
        x, d1, d2 = self._path.evaluate(np.minimum(s, self._path.end))
        d3 = np.diff(d2, axis=0) / self.spacing
        left = d3[:-1] if before else np.vstack([d3[:1], d3[:-1]])
        right, new = d3[before:], slice(before, -1)
        x, d1, d2 = x[new], d1[new], d2[new]
        columns = [d1, d2, np.minimum(left, right), np.maximum(left, right)]
        if self._model is not None:
            columns += self._dynamics(x, d1, d2)
        rows = np.hstack(columns)
        self._table = np.concatenate([self._table, rows]) if done else rows
        return True

    def _dynamics(self, x: np.ndarray, d1: np.ndarray, d2: np.ndarray) -> list[np.ndarray]:
        """Return the factors of s_ddot, s_dot^2, s_dot and 1 in the efforts."""  # (n, nq) each
        assert self._model is not None
        nodes = np.arange(len(x))
        known = np.unique(np.append(nodes[::DYNAMICS_EVERY], nodes[-1]))
        mass, coriolis, damping, gravity, friction = PathDynamics.along(
            self._model, x[known], d1[known], d2[known]
        )
        return [
            np.column_stack([np.interp(nodes, known, column) for column in factors.T])
            for factors in (mass, coriolis, damping, gravity + friction)
        ]

    def nodes(self, first: int = 0) -> np.ndarray:
        """Return the known rows from a node on."""  # (n, k)
        return self._table[first:]

    def at(self, s: np.ndarray) -> np.ndarray:
        """Return rows at path parameters, linear between the nodes."""  # (n, k)
        places = (s - self._start) / self.spacing
        self.extend(int(places.max()) + 2)
        i = np.minimum(places.astype(int), len(self._table) - 2)
        part = np.minimum(places - i, 1.0)[:, np.newaxis]
        return (1.0 - part) * self._table[i] + part * self._table[i + 1]

    def min_acceleration(self, rows: np.ndarray, s_dot: np.ndarray) -> np.ndarray:
        """Return the lowest path acceleration of acceleration and effort limits, at most 0.

        Args:
            rows: Rows of n path parameters.  # (n, k)
            s_dot: Path velocities at each of them, or the same for all.  # (n, j) or (1, j)
        """
        m = self._m
        x, s_dot = (s_dot * s_dot)[:, np.newaxis, :], s_dot[:, np.newaxis, :]
        d1, d2 = rows[:, :m, np.newaxis], rows[:, m : 2 * m, np.newaxis]
        low = self._lowest(d1, d2 * x, self._path.limits.acceleration)
        if self._model is not None:
            mass, coriolis, damping, rest = np.split(rows[:, 4 * m :, np.newaxis], 4, axis=1)
            effort = STOP_EFFORT_FRACTION * self._model.limits.effort
            low = np.maximum(low, self._lowest(mass, coriolis * x + damping * s_dot + rest, effort))
        return low  # (n, j)

    def _lowest(self, factor: np.ndarray, rest: np.ndarray, limit: np.ndarray) -> np.ndarray:
        """Return the lowest u with ``|factor u + rest| <= limit`` for all coordinates."""
        limit = np.maximum((self.margin * limit)[:, np.newaxis], np.abs(rest))
        low = -(limit + np.sign(factor) * rest) / np.maximum(np.abs(factor), TINY)
        return np.asarray(low.max(axis=1))

    def jerk_bounds(self, rows: np.ndarray, s_dot: np.ndarray, s_ddot: np.ndarray) -> JerkBounds:
        """Return the bounds from jerk limits at n path parameters, velocities and accelerations."""
        m = self._m
        s_dot, s_ddot = s_dot[:, np.newaxis], s_ddot[:, np.newaxis]
        d1, cubed = rows[:, :m], s_dot**3
        factor = 3.0 * rows[:, m : 2 * m] * s_dot  # of s_ddot
        low, high = rows[:, 2 * m : 3 * m] * cubed, rows[:, 3 * m : 4 * m] * cubed
        own = np.maximum(np.abs(low), np.abs(high))
        limit = np.maximum(self.margin * self._path.limits.jerk, own)
        size, sign = np.maximum(np.abs(d1), TINY), np.sign(d1)
        forward_low = np.where(d1 < 0.0, -high, low)
        forward_high = np.where(d1 < 0.0, -low, high)
        by_acceleration = sign * factor * s_ddot
        lowest = (-(limit + forward_low + by_acceleration) / size).max(axis=1)
        highest = ((limit - forward_high - by_acceleration) / size).min(axis=1)
        left = limit + np.where(factor > 0.0, low, -high)  # s_ddot < 0 acts towards this side
        constant = -(left / np.maximum(np.abs(factor), TINY)).min(axis=1)
        return JerkBounds(lowest, highest, (limit / size).min(axis=1), constant)
