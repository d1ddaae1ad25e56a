"""What can be reached along a path under limits that are linear in ``z = ds^2`` and ``u = dds``.

After H. Pham and Q.-C. Pham, "A New Approach to Time-Optimal Path Parameterization Based on
Reachability Analysis", IEEE T-RO 34 (2018): one pass backwards finds from where rest can still be
reached, one forwards goes as fast as that and the limits allow.
"""

import numpy as np

KEPT = 0.5  # of z from one point to the next, at the least, because of any one limit
_TINY = 1e-9


def greatest_squares(
    rates: np.ndarray,
    squares: np.ndarray,
    above: np.ndarray,
    below: np.ndarray,
    most: np.ndarray,
) -> np.ndarray:
    """Give the greatest ``z`` at points in equal steps from rest at 0 to rest at 1.

    Args:
        rates: What multiplies u in ``-below <= rates u + squares z <= above``.  # (n, k)
        squares: What multiplies z.  # (n, k)
        above: What is left on one side, more than 0.  # (n, k)
        below: What is left on the other.  # (n, k)
        most: The greatest z that other limits allow.  # (n,)
    """  # (n,)
    n = len(most)
    h = 1.0 / (n - 1)
    # down <= u - slope z <= up
    steep = np.abs(rates) > _TINY
    safe = np.where(steep, rates, 1.0)
    slope = np.where(steep, -squares / safe, 0.0)
    ends = above / safe, -below / safe
    up = np.where(steep, np.maximum(*ends), np.inf)
    down = np.where(steep, np.minimum(*ends), -np.inf)
    # Where a joint turns back within a few steps its limit is one of z: with more of that, the u
    # that it asks for would leave less than the share `KEPT` of z after a step, or nothing.
    tight = np.abs(squares) - (1.0 - KEPT) / (2.0 * h) * np.abs(rates)
    flat = tight > _TINY
    room = np.where(squares > 0.0, above, below) / np.where(flat, tight, 1.0)
    most = np.minimum(most, np.where(flat, room, np.inf).min(axis=1))
    most = np.minimum(most, _admissible(slope, up, down))
    # From one point to the next u stays, and the limits at both hold for it.
    leaves, arrives = 1.0 + 2.0 * h * slope[:-1], 1.0 - 2.0 * h * slope[1:]
    low, high = 2.0 * h * down, 2.0 * h * up
    share = np.hstack([_inverse(leaves), np.maximum(arrives, 0.0)])
    rest = np.hstack([_over(-low[:-1], leaves), np.where(arrives > 0.0, -low[1:], np.inf)])
    rise = np.hstack([leaves, _inverse(arrives)])
    gain = np.hstack([high[:-1], _over(high[1:], arrives)])
    last = np.zeros(n)  # the greatest from which the end can still be reached
    z, least = 0.0, np.minimum.reduce
    for i, bound in zip(range(n - 2, -1, -1), most[-2::-1].tolist(), strict=True):
        z = last[i] = max(0.0, min(float(least(z * share[i] + rest[i])), bound))
    fastest = np.zeros(n)
    z = 0.0
    for i, bound in enumerate(last[1:].tolist()):
        z = fastest[i + 1] = max(0.0, min(float(least(z * rise[i] + gain[i])), bound))
    return fastest


def _inverse(x: np.ndarray) -> np.ndarray:
    """Give 1 / x where x is positive, otherwise 0."""
    positive = x > _TINY
    return np.where(positive, 1.0 / np.where(positive, x, 1.0), 0.0)


def _over(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Give x / y where y is positive; otherwise nothing binds."""
    positive = y > _TINY
    return np.where(positive, x / np.where(positive, y, 1.0), np.inf)


def _admissible(slope: np.ndarray, up: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Give the greatest ``ds^2`` at which some acceleration is still allowed."""  # (n,)
    nearing = slope[:, np.newaxis, :] - slope[:, :, np.newaxis]
    apart = up[:, :, np.newaxis] - down[:, np.newaxis, :]
    meets = nearing > _TINY
    return np.where(meets, apart / np.where(meets, nearing, 1.0), np.inf).min(axis=(1, 2))
