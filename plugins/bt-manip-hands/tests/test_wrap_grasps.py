"""A hand wraps thumb and fingers around an object."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.grippers import Solid
from bt_manip_hands.wrap_grasps import HandShape, WrapGraspGenerator

DOWN = np.array([0.0, 0.0, -1.0])


def test_a_hand_wraps_a_block_from_above_or_from_the_side_but_not_from_below():
    block = Solid("box", np.array([0.03, 0.03, 0.03]), pin.SE3.Identity(), 0.7)
    shape = HandShape(np.array([0.0, 1.0, 0.0]), 0.01, 0.08, 0.1)
    found = WrapGraspGenerator("it", [block], shape, np.zeros(3)).candidates(DOWN)
    cosines = [grasp.T_ot.rotation[:, 2] @ DOWN for grasp in found]
    assert max(cosines) == pytest.approx(1.0)
    assert min(cosines) == pytest.approx(0.0, abs=0.05)
