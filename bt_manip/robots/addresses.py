"""A robot's numbers in the arrays of a compiled model."""

from collections.abc import Callable

import numpy as np


def reader(array: np.ndarray, addresses: np.ndarray) -> Callable[[], np.ndarray]:
    """Give what reads some numbers of an array, as they are whenever it is called.

    Finding a part of an array takes longer than most of what is done with it in a control step:
    where the numbers lie together, which they mostly do, one view of them is made for good.

    Args:
        array: An array that the physics writes; it is only read.
        addresses: Where the numbers are in it.
    """
    array = array.view()
    array.flags.writeable = False  # whoever works in place on them must not move the physics
    if not _lie_together(addresses):
        return lambda: array[addresses]
    numbers = _part(array, addresses)
    return lambda: numbers


def writer(array: np.ndarray, addresses: np.ndarray) -> Callable[[np.ndarray], None]:
    """Give what writes some numbers of an array, found once as for `reader`.

    Args:
        array: An array that the physics reads.
        addresses: Where the numbers go in it.
    """
    together = _lie_together(addresses)
    target, where = (_part(array, addresses), slice(None)) if together else (array, addresses)

    def write(numbers: np.ndarray) -> None:
        target[where] = numbers

    return write


def _lie_together(addresses: np.ndarray) -> bool:
    first, *_ = numbers = addresses.tolist()
    return numbers == list(range(first, first + len(numbers)))


def _part(array: np.ndarray, addresses: np.ndarray) -> np.ndarray:
    return array[addresses[0] : addresses[0] + len(addresses)]
