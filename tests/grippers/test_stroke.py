"""A finger travels inside its limits and can be turned or stopped on the way."""

import numpy as np
import pytest

from bt_manip.grippers.two_finger.stroke import Motion, Stroke, StrokeLimits

DT = 1e-3
LIMITS = StrokeLimits(0.1, 5.0, 500.0)


def travel(stroke):
    motions = [stroke.start]
    while not stroke.done:
        motions.append(stroke.advance(DT))
    return np.array(motions)


def test_it_arrives_at_rest_inside_all_limits_and_turns_on_the_way_without_a_jump():
    first = Stroke(Motion(0.04, 0.0, 0.0), 0.01, LIMITS)
    for _ in range(100):
        here = first.advance(DT)
    for start, target in ((first.start, 0.01), (here, 0.04)):
        s, v, a = travel(Stroke(start, target, LIMITS)).T
        assert (s[0], v[0], a[0]) == start
        assert (s[-1], v[-1], a[-1]) == (pytest.approx(target), 0.0, 0.0)
        assert np.abs(v).max() <= 0.1 + 1e-9
        assert np.abs(a).max() <= 5.0 + 1e-9
        assert np.abs(np.diff(a) / DT).max() <= 500.0 * (1 + 1e-6)
        np.testing.assert_allclose(np.diff(s) / DT, 0.5 * (v[1:] + v[:-1]), atol=1e-4)


def test_it_brakes_as_soon_as_the_limits_allow():
    motions = travel(Stroke(Motion(0.03, -0.1, 0.0), None, LIMITS))
    # 10 ms of jerk up and down, and 10 ms at 5 m/s2 between them: 0.1 m/s.
    assert len(motions) - 1 == pytest.approx(30, abs=1)
    assert motions[-1][1] == 0.0
    assert motions[-1][0] == pytest.approx(0.03 - 0.1 * 0.015, abs=1e-6)
