"""Poses from positions and quaternions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bt_manip import spatial


def test_a_quaternion_of_any_length_is_the_rotation_of_its_direction():
    for w, x, y, z in 3.0 * np.random.default_rng(0).normal(size=(10, 4)):
        R = spatial.pose((0.1, 0.2, 0.3), (w, x, y, z)).rotation
        np.testing.assert_allclose(R, Rotation.from_quat([x, y, z, w]).as_matrix(), atol=1e-12)


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_quaternion_that_is_not_finite_is_refused(number):
    with pytest.raises(ValueError, match="a quaternion is four finite numbers, not all zero, got"):
        spatial.pose((0.0, 0.0, 0.0), (number, 0.0, 0.0, 1.0))


def test_a_quaternion_of_zeros_is_refused():
    with pytest.raises(ValueError, match="not all zero"):
        spatial.pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
