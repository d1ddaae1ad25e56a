"""Numbers of a robot are read and written where they lie, together or not."""

import numpy as np
import pytest

from bt_manip.robots import reader, writer

TOGETHER, APART = np.array([2, 3, 4]), np.array([4, 0, 5])


@pytest.mark.parametrize("addresses", [TOGETHER, APART], ids=["together", "apart"])
def test_they_are_read_as_they_are_at_each_time(addresses):
    array = np.arange(6.0)
    read = reader(array, addresses)
    assert read().tolist() == array[addresses].tolist()
    array[:] = array[::-1].copy()
    assert read().tolist() == array[addresses].tolist()


@pytest.mark.parametrize("addresses", [TOGETHER, APART], ids=["together", "apart"])
def test_they_are_written_where_they_belong_and_nowhere_else(addresses):
    array, expected = np.zeros(6), np.zeros(6)
    writer(array, addresses)(np.array([1.0, 2.0, 3.0]))
    expected[addresses] = [1.0, 2.0, 3.0]
    assert array.tolist() == expected.tolist()


@pytest.mark.parametrize("addresses", [TOGETHER, APART], ids=["together", "apart"])
def test_who_works_on_what_was_read_does_not_change_what_is_simulated(addresses):
    array = np.arange(6.0)
    numbers = reader(array, addresses)()
    if addresses is TOGETHER:
        with pytest.raises(ValueError, match="read-only"):
            numbers += 1.0
    else:
        numbers += 1.0
    assert array.tolist() == list(range(6))
