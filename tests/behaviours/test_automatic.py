"""Values that behaviours choose themselves."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.behaviours import feasible_force
from bt_manip.behaviours.automatic import first_reachable
from bt_manip.exceptions import MotionError


def test_a_force_is_reduced_to_four_fifths_of_what_arm_and_grip_exert():
    static_force = {("q", "down"): 50.0}
    model = SimpleNamespace(static_force=lambda *given: static_force[given])
    arm = SimpleNamespace(model=model, robot=SimpleNamespace(q="q"))
    given = ((100.0, np.inf), (30.0, np.inf), (100.0, 20.0), (15.0, 20.0), (100.0, 60.0))
    forces = [feasible_force(preferred, arm, "down", held) for preferred, held in given]
    assert forces == [40.0, 30.0, 16.0, 15.0, 40.0]


def test_the_first_height_that_is_not_unreachable_is_taken():
    tried, reasons = [], {0.4: "unreachable", 0.3: "unreachable", 0.1: "collision"}

    def move(height):
        tried.append(height)
        if height in reasons:
            raise MotionError(f"not {height}", reason=reasons[height])

    first_reachable((0.4, 0.3, 0.2, 0.1), move)
    assert tried == [0.4, 0.3, 0.2]
    for heights, message in (((0.4, 0.1, 0.2), "not 0.1"), ((0.4, 0.3), "not 0.3")):
        with pytest.raises(MotionError, match=message):
            first_reachable(heights, move)
