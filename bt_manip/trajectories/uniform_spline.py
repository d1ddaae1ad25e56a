"""Quintic splines over equal steps of a parameter."""

from functools import lru_cache
from math import factorial

import numpy as np

# Powers 0 to 5 of the place in an interval (rows) from the six B-spline coefficients around it
# (columns); see C. de Boor, A Practical Guide to Splines, for the cardinal B-splines.
_TO_POWERS = (
    np.array(
        [
            [1, 26, 66, 26, 1, 0],
            [-5, -50, 0, 50, 5, 0],
            [10, 20, -60, 20, 10, 0],
            [-10, 20, 0, -20, 10, 0],
            [5, -20, 30, -20, 5, 0],
            [-1, 5, -10, 10, -5, 1],
        ]
    )
    / 120.0
)
_AT_KNOT = np.array([1, 26, 66, 26, 1]) / 120.0
_SIXTH_DIFFERENCE = np.array([1, -6, 15, -20, 15, -6, 1])


class UniformSpline:
    """Interpolate vectors at equal steps from 0 to 1, continuous to the fourth derivative."""

    def __init__(self, knots: np.ndarray) -> None:
        """Interpolate.

        Args:
            knots: At least seven vectors.  # (n + 1, m)
        """
        n = len(knots) - 1
        if n < 6:
            raise ValueError(f"a quintic spline has at least 7 knots, got {n + 1}")
        coefficients = _coefficients_of_knots(n) @ knots
        around = np.stack([coefficients[k : k + n] for k in range(6)], axis=1)  # (n, 6, m)
        self._powers = np.einsum("pk,nkm->pnm", _TO_POWERS, around)
        self._n = n

    def __call__(self, s: np.ndarray, order: int = 0) -> list[np.ndarray]:
        """Give values and derivatives up to an order at many places."""  # (len(s), m) each
        scaled = s * self._n
        interval = np.minimum(np.maximum(scaled.astype(int), 0), self._n - 1)
        x = (scaled - interval)[:, np.newaxis]
        powers = self._powers.take(interval, axis=1)
        # Horner's scheme, for the value and all derivatives at once.
        found = [powers[5], *(np.zeros_like(powers[5]) for _ in range(order))]
        for power in range(4, -1, -1):
            for derivative in range(order, 0, -1):
                found[derivative] *= x
                found[derivative] += found[derivative - 1]
            found[0] *= x
            found[0] += powers[power]
        for derivative in range(1, order + 1):
            found[derivative] *= factorial(derivative) * float(self._n) ** derivative
        return found


@lru_cache(maxsize=16)
def _coefficients_of_knots(n: int) -> np.ndarray:
    """Give the matrix that makes coefficients of knots; it depends on their number only."""
    system = np.zeros((n + 5, n + 5))
    for i in range(n + 1):
        system[i, i : i + 5] = _AT_KNOT
    # Not-a-knot: the fifth derivative does not jump at the two knots next to each end.
    for row, first in zip(range(n + 1, n + 5), (0, 1, n - 3, n - 2), strict=True):
        system[row, first : first + 7] = _SIXTH_DIFFERENCE
    return np.linalg.inv(system)[:, : n + 1]  # (n + 5, n + 1)
