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
    divisor = np.where(moves, a, 1.0)
    slope = -b / divisor
    ends = above / divisor, -below / divisor
    highest = np.where(moves, np.maximum(*ends), np.inf)
    lowest = np.where(moves, np.minimum(*ends), -np.inf)
    # Where a joint reverses within a few steps, its constraint bounds x: with a greater x, its u
    # would leave less than the share `KEPT` of x after one step.
    curvature = np.abs(b) - (1.0 - KEPT) / (2.0 * h) * np.abs(a)
    curved = curvature > TINY
    bound = np.where(b > 0.0, above, below) / np.where(curved, curvature, 1.0)
    max_x = np.minimum(max_x, np.where(curved, bound, np.inf).min(axis=1))
    max_x = np.minimum(max_x, _max_admissible(slope, highest, lowest))
    # u is constant between two points, and the constraints of both points hold for it.
    leaving, arriving = 1.0 + 2.0 * h * slope[:-1], 1.0 - 2.0 * h * slope[1:]
    low, high = 2.0 * h * lowest, 2.0 * h * highest
    back_gain = np.hstack([_inverse(leaving), arriving])
    back_rest = np.hstack([_ratio(-low[:-1], leaving), np.where(arriving > 0.0, -low[1:], np.inf)])
    gain = np.hstack([leaving, _inverse(arriving)])
    rest = np.hstack([high[:-1], _ratio(high[1:], arriving)])
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


def _inverse(x: np.ndarray) -> np.ndarray:
    """Return 1 / x where x is positive, otherwise 0."""
    positive = x > TINY
    return np.where(positive, 1.0 / np.where(positive, x, 1.0), 0.0)


def _ratio(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return x / y where y is positive, otherwise infinity."""
    positive = y > TINY
    return np.where(positive, x / np.where(positive, y, 1.0), np.inf)


def _max_admissible(slope: np.ndarray, highest: np.ndarray, lowest: np.ndarray) -> np.ndarray:
    """Return the greatest x at which the constraints leave some u (maximum velocity curve)."""
    closing = slope[:, np.newaxis, :] - slope[:, :, np.newaxis]
    apart = highest[:, :, np.newaxis] - lowest[:, np.newaxis, :]
    meets = closing > TINY
    return np.where(meets, apart / np.where(meets, closing, 1.0), np.inf).min(axis=(1, 2))  # (n,)
