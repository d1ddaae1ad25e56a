"""Grasp candidates as text."""

import pytest

from bt_manip.robots import GraspCandidate
from tests.grippers.shapes import candidates, solid


def test_a_grasp_survives_conversion_to_text():
    grasp = next(iter(candidates(solid("box", 0.025, 0.02, 0.03))))
    again = GraspCandidate.from_text(grasp.to_text())
    assert again.T_ot.isApprox(grasp.T_ot, 1e-12) and again.width == grasp.width


@pytest.mark.parametrize("text", ["", "1;2;3", "0;0;0;1;0;0;0;nan", "0;0;0;1;0;0;0;-1", "a"])
def test_text_that_is_no_grasp_is_rejected(text):
    with pytest.raises(ValueError, match="a grasp is"):
        GraspCandidate.from_text(text)
