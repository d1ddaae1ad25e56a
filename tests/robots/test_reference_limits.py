"""References that are written one by one are judged by what they make of the arm's motion."""

import numpy as np
import pytest

from bt_manip.robots import MotionLimits

ONE = np.ones(2)
LIMITS = MotionLimits(-9 * ONE, 9 * ONE, 2.0 * ONE, 5.0 * ONE, 100.0 * ONE, ONE)


@pytest.mark.parametrize("times", [(0.02, 0.02), (0.01, 0.05), (0.05, 0.01)])
@pytest.mark.parametrize("joint", [0, 1])
def test_references_of_a_constant_acceleration_are_accepted_up_to_the_limit(times, joint):
    t = np.array([0.0, times[0], sum(times)])
    for a, problem in ((4.9, ""), (-4.9, ""), (6.0, "acceleration"), (-6.0, "acceleration")):
        q = np.outer(0.5 * a * t**2, np.arange(2) == joint)
        found = LIMITS.reference_problem(q, times)
        assert found.startswith(f"{problem} of joint {joint + 1}" if problem else "")
        assert bool(found) is bool(problem)
    for v, problem in ((1.98, ""), (-1.98, ""), (2.2, "velocity"), (-2.2, "velocity")):
        q = np.outer(v * t, np.arange(2) == joint)
        found = LIMITS.reference_problem(q, times)
        assert found.startswith(f"{problem} of joint {joint + 1}" if problem else "")
        assert bool(found) is bool(problem)
