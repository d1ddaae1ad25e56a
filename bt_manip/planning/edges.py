"""Straight lines in joint space, looked at step by step."""

from collections.abc import Callable
from functools import cache

import numpy as np

Free = Callable[[np.ndarray], bool]  # tells of a configuration (nq,) whether it is free


def line(start: np.ndarray, end: np.ndarray, step: float) -> np.ndarray:
    """Give configurations on the way from a start to an end, the start left out.

    Args:
        start: Where it begins.  # (nq,)
        end: Where it ends.  # (nq,)
        step: Longest way of a joint between two of them [rad].
    """  # (n, nq)
    way = end - start
    n = max(1, int(np.ceil(np.abs(way).max() / step)))
    return start + np.outer(np.arange(1, n + 1) / n, way)


def edge_is_free(start: np.ndarray, end: np.ndarray, free: Free, step: float) -> bool:
    """Tell whether the way to an end is free, looking where it is likeliest blocked first."""
    between = line(start, end, step)
    return all(free(between[i]) for i in _scattered(len(between)))


@cache
def _scattered(n: int) -> tuple[int, ...]:
    """Order n places so that each next one is far from those before: the last, then by halves."""
    bits = max(1, (n - 1).bit_length())
    reversed_bits = (int(f"{i:0{bits}b}"[::-1], 2) for i in range(1 << bits))
    return tuple(n - 1 - i for i in reversed_bits if i < n)
