"""States of cells with different numbers of objects, in one array."""

import numpy as np

from bt_manip_learn.demonstrations.recorder import _same_length


def test_what_a_shorter_state_lacks_is_not_a_number():
    rows = _same_length([np.arange(3.0).tobytes(), np.arange(5.0).tobytes()])
    np.testing.assert_array_equal(rows, [[0, 1, 2, np.nan, np.nan], [0, 1, 2, 3, 4]])
