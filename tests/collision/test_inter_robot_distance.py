"""Two motions are too close where any of their samples is."""

import numpy as np
import pytest

from bt_manip.collision import InterRobotDistance


@pytest.mark.parametrize("n", [1, 4, 10, 11, 26, 47])
def test_of_two_motions_near_each_other_every_sample_counts(n):
    class Known(InterRobotDistance):
        def __init__(self):
            pass

        def distance(self, q_first, q_second):
            assert np.array_equal(q_first, -q_second)
            return distances[int(q_first[0])]

    samples = np.arange(float(n))[:, np.newaxis]
    distances = np.full(n, 0.03)
    assert not Known().too_close(samples, -samples, 0.03)
    for i in range(n):
        distances[:], distances[i] = 0.03, 0.029
        assert Known().too_close(samples, -samples, 0.03), i


def test_far_robots_are_measured_at_few_samples():
    measured = []

    class Far(InterRobotDistance):
        def __init__(self):
            pass

        def distance(self, q_first, q_second):
            measured.append(int(q_first[0]))
            return 0.07

    assert not Far().too_close(np.arange(95.0)[:, np.newaxis], np.zeros((95, 1)), 0.03)
    assert np.diff([*measured, 94]).max() <= 10 and len(measured) < 12  # 2.5 m/s at 2 ms: 50 mm
