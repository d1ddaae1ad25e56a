"""Fast access to a robot's elements of the arrays of a compiled model."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np


def reader(array: np.ndarray, addresses: np.ndarray) -> Callable[[], np.ndarray]:
    """Return a function that reads the current values of some elements of an array.

    Contiguous elements, the usual case, are read through one read-only view, because indexing in
    every control step would take longer than most computations with the result. Other elements
    are copied.

    Args:
        array: An array that the physics writes.
        addresses: Indices of the elements.
    """
    array = array.view()
    array.flags.writeable = False  # in-place operations on the result must not change the physics
    if not _lie_together(addresses):
        return lambda: array[addresses]
    numbers = _part(array, addresses)
    return lambda: numbers


def writer(array: np.ndarray, addresses: np.ndarray) -> Callable[[np.ndarray], Any]:
    """Return a function that writes some elements of an array, indexed once as in `reader`.

    Args:
        array: An array that the physics reads.
        addresses: Indices of the elements.
    """
    together = _lie_together(addresses)
    target, where = (_part(array, addresses), ...) if together else (array, addresses)
    return partial(target.__setitem__, where)


def _lie_together(addresses: np.ndarray) -> bool:
    first, *_ = numbers = addresses.tolist()
    return numbers == list(range(first, first + len(numbers)))


def _part(array: np.ndarray, addresses: np.ndarray) -> np.ndarray:
    return array[addresses[0] : addresses[0] + len(addresses)]
