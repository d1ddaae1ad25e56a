"""Numbers of a robot are read and written where they lie, together or not."""

import numpy as np
import pytest

from bt_manip.robots import reader, writer

TOGETHER, APART = np.array([2, 3, 4]), np.array([4, 0, 5])


@pytest.mark.parametrize("addresses", [TOGETHER, APART], ids=["together", "apart"])
def test_numbers_are_read_as_they_are_at_each_time_and_written_nowhere_else(addresses):
    array, expected = np.arange(6.0), np.arange(5.0, -1.0, -1.0)
    read = reader(array, addresses)
    assert read().tolist() == array[addresses].tolist()
    array[:] = expected
    assert read().tolist() == expected[addresses].tolist()
    numbers = read()
    if addresses is TOGETHER:
        with pytest.raises(ValueError, match="read-only"):
            numbers += 1.0
    else:
        numbers += 1.0
    assert array.tolist() == expected.tolist()
    writer(array, addresses)(np.array([1.0, 2.0, 3.0]))
    expected[addresses] = [1.0, 2.0, 3.0]
    assert array.tolist() == expected.tolist()
