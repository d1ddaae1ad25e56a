"""Where a robot's numbers lie in the arrays of a compiled model."""

import numpy as np


def part_of(addresses: np.ndarray) -> slice | np.ndarray:
    """Give what indexes a part of an array: a slice, which is fastest, where it lies together."""
    first = int(addresses[0])
    if np.array_equal(addresses, np.arange(first, first + len(addresses))):
        return slice(first, first + len(addresses))
    return addresses.copy()
