"""Values that behaviours choose themselves."""

from types import SimpleNamespace

import numpy as np

from bt_manip.behaviours import feasible_force


def test_a_force_is_reduced_to_four_fifths_of_what_arm_and_grip_exert():
    static_force = {("q", "down"): 50.0}
    model = SimpleNamespace(static_force=lambda *given: static_force[given])
    arm = SimpleNamespace(model=model, robot=SimpleNamespace(q="q"))
    given = ((100.0, np.inf), (30.0, np.inf), (100.0, 20.0), (15.0, 20.0), (100.0, 60.0))
    forces = [feasible_force(preferred, arm, "down", held) for preferred, held in given]
    assert forces == [40.0, 30.0, 16.0, 15.0, 40.0]
