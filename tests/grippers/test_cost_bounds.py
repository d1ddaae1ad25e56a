"""Costs of grasps lie between 0 and their weight, for objects of all sizes."""

import pytest

from bt_manip.grippers.two_finger.antipodal_grasps import SLACK_WEIGHT
from tests.grippers.shapes import HAND, candidates, solid


@pytest.mark.parametrize("half", [0.002, 0.01, 0.025, 0.036, 0.0385, 0.0395])  # [m]
def test_the_cost_of_a_narrow_opening_is_bounded_and_only_objects_as_wide_pay_it(half):
    found = candidates(solid("box", half, half, 0.03))
    slack, width = found.costs["slack"], found.width
    assert len(slack) and (slack >= 0.0).all() and (slack <= SLACK_WEIGHT).all()
    assert (slack[width < HAND.stroke - 0.011] == 0.0).all()
    assert (slack[width > HAND.stroke - 0.005] > 0.25 * SLACK_WEIGHT).all()
