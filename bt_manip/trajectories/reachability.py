"""Time-optimal path parameterization by reachability analysis (TOPP-RA).

H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis", IEEE T-RO 34 (2018). A backward pass computes the controllable sets, the squared path
velocities from which rest at the end can be reached; a forward pass takes the greatest reachable
one of them at each point.
"""

import numpy as np

from .path_limits import TINY

KEPT = 0.5  # of x kept from one point to the next, at least: keeps a joint that hardly moves, but
# bends, from stopping the whole motion


def time_optimal_velocities(
    a: np.ndarray, b: np.ndarray, above: np.ndarray, below: np.ndarray, max_x: np.ndarray
) -> np.ndarray:
    """Return the greatest ``x = s_dot^2`` at equal steps of s, from rest at 0 to rest at 1.

    Args:
        a: Multiplies ``u = s_ddot`` in the constraints ``-below <= a u + b x <= above``.  # (n, k)
        b: Multiplies x.  # (n, k)
        above: Upper bounds, more than 0.  # (n, k)
        below: Negative lower bounds, more than 0.  # (n, k)
        max_x: Upper bounds of x by other limits.  # (n,)
    """  # (n,)
    n = len(max_x)
    h = 1.0 / (n - 1)
    # The constraints as lowest <= u - slope x <= highest.
    moves = np.abs(a) > TINY
    slope = _quotient(-b, a, moves, 0.0)
    ends = _quotient(above, a, moves, np.inf), _quotient(-below, a, moves, -np.inf)
    highest, lowest = np.maximum(*ends), np.minimum(*ends)
    # Where a joint reverses within a few steps, its constraint bounds x: with a greater x, its u
    # would leave less than the share `KEPT` of x after one step.
    curvature = np.abs(b) - (1.0 - KEPT) / (2.0 * h) * np.abs(a)
    bound = _quotient(np.where(b > 0.0, above, below), curvature, curvature > TINY, np.inf)
    max_x = np.minimum(max_x, bound.min(axis=1))
    max_x = np.minimum(max_x, _max_admissible(slope, highest, lowest))
    # u is constant between two points, and the constraints of both points hold for it.
    leaving, arriving = 1.0 + 2.0 * h * slope[:-1], 1.0 - 2.0 * h * slope[1:]
    low, high = 2.0 * h * lowest, 2.0 * h * highest
    leaves, arrives = leaving > TINY, arriving > TINY
    back_gain = np.hstack([_quotient(1.0, leaving, leaves, 0.0), arriving])
    after = np.where(arrives, -low[1:], np.inf)
    back_rest = np.hstack([_quotient(-low[:-1], leaving, leaves, np.inf), after])
    gain = np.hstack([leaving, _quotient(1.0, arriving, arrives, 0.0)])
    rest = np.hstack([high[:-1], _quotient(high[1:], arriving, arrives, np.inf)])
    controllable = np.zeros(n)
    x, least = 0.0, np.minimum.reduce
    for i, bound_x in zip(range(n - 2, -1, -1), max_x[-2::-1].tolist(), strict=True):
        reached = float(least(x * back_gain[i] + back_rest[i]))
        x = controllable[i] = min(reached, bound_x)
    greatest = np.zeros(n)
    x = 0.0
    for i, bound_x in enumerate(controllable[1:].tolist()):
        x = greatest[i + 1] = max(0.0, min(float(least(x * gain[i] + rest[i])), bound_x))
    return greatest


def _quotient(
    x: np.ndarray | float, y: np.ndarray, where: np.ndarray, otherwise: float
) -> np.ndarray:
    """Return x / y where that is wanted, and a number elsewhere."""
    return np.divide(x, y, where=where, out=np.full(y.shape, otherwise))


def _max_admissible(slope: np.ndarray, highest: np.ndarray, lowest: np.ndarray) -> np.ndarray:
    """Return the greatest x at which the constraints leave some u (maximum velocity curve)."""
    closing = slope[:, np.newaxis, :] - slope[:, :, np.newaxis]
    apart = highest[:, :, np.newaxis] - lowest[:, np.newaxis, :]
    return _quotient(apart, closing, closing > TINY, np.inf).min(axis=(1, 2))  # (n,)
