"""Tolerances of directions are chords of the unit sphere."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.kinematics.residuals import chord


@pytest.mark.parametrize("angle", [0.0, 1e-3, 1.0, np.pi])
def test_the_chord_of_an_angle_is_the_distance_of_two_directions_at_it(angle):
    first = np.array([1.0, 0.0, 0.0])
    second = pin.exp3(angle * np.array([0.0, 0.6, 0.8])) @ first
    assert chord(angle) == pytest.approx(float(np.linalg.norm(second - first)), abs=1e-12)


def test_an_angle_beyond_half_a_turn_allows_every_direction():
    assert chord(4.0) == 2.0 and chord(np.inf) == np.inf
