"""Actions in physical units and scaled to [-1, 1]."""

import numpy as np

from bt_manip_learn.agents import ActionSpace


def test_actions_are_scaled_between_their_bounds_and_clipped_and_choices_are_kept():
    low, high = np.array([-2.0, 0.5, -0.3]), np.array([1.0, 4.5, 0.1])
    space = ActionSpace(low, high, ("a", "b", "c"), ("rad", "m", "-"))
    assert (space.shape, space.dtype) == ((3,), "float32")
    scaled, units = [-0.7, 0.2, 0.9], [-1.55, 2.9, 0.08]
    np.testing.assert_allclose(space.physical(scaled), units)
    np.testing.assert_allclose(space.physical([-2.0, 3.0, 0.4]), [-3.5, 8.5, -0.02])
    assert space.physical(np.zeros(2)).tolist() == [0.0, 0.0]  # refused later
    rows = space.normalized([units, [-3.5, 8.5, -0.02]])
    np.testing.assert_allclose(rows, [scaled, [-1.0, 1.0, 0.4]], atol=1e-6)
    choices = ActionSpace(np.zeros(1), np.full(1, 2.0), ("choice",), ("-",), ("", "pick", "place"))
    assert (choices.shape, choices.dtype) == ((), "int64")
    assert choices.physical(2) == choices.normalized(2) == 2
