"""Discretized segments in joint space."""

import numpy as np

from bt_manip.planning import discretize_segment, edge_is_free


def test_configurations_on_a_segment_are_even_and_end_at_its_end():
    between = discretize_segment(np.zeros(2), np.array([0.1, -0.05]), 0.03)
    assert np.allclose(between[:, 0], [0.025, 0.05, 0.075, 0.1])


def test_an_edge_is_checked_at_its_end_first_and_not_at_its_start():
    checked = []
    edge_is_free(np.zeros(1), np.ones(1), lambda q: checked.append(float(q[0])) or True, 0.25)
    assert checked[0] == 1.0 and sorted(checked) == [0.25, 0.5, 0.75, 1.0]
