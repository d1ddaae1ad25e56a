"""Straight segments in joint space and their collision checks: the local planner."""

from collections.abc import Callable
from functools import cache

import numpy as np

IsFree = Callable[[np.ndarray], bool]  # tells whether a configuration (nq,) is collision-free


def discretize_segment(start: np.ndarray, end: np.ndarray, step: float) -> np.ndarray:
    """Return evenly spaced configurations on a segment, its start excluded.

    Args:
        start: First configuration [rad].  # (nq,)
        end: Last configuration [rad].  # (nq,)
        step: Largest displacement of a joint between two of them [rad].
    """  # (n, nq)
    offset = end - start
    n = max(1, int(np.ceil(np.abs(offset).max() / step)))
    return start + np.outer(np.arange(1, n + 1) / n, offset)


def edge_is_free(start: np.ndarray, end: np.ndarray, is_free: IsFree, step: float) -> bool:
    """Tell whether a segment is collision-free, checking by bisection.

    Args:
        start: First configuration, which is not checked [rad].  # (nq,)
        end: Last configuration [rad].  # (nq,)
        is_free: Tells whether a configuration is collision-free.
        step: Largest displacement of a joint between two checks [rad].
    """
    configurations = discretize_segment(start, end, step)
    return all(is_free(configurations[i]) for i in _bisection_order(len(configurations)))


@cache
def _bisection_order(n: int) -> tuple[int, ...]:
    """Return indices below n: the last one, then by halves (van der Corput sequence)."""
    bits = max(1, (n - 1).bit_length())
    reversed_bits = (int(f"{i:0{bits}b}"[::-1], 2) for i in range(1 << bits))
    return tuple(n - 1 - i for i in reversed_bits if i < n)
