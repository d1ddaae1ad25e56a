"""Poses of `bt_manip.spatial` from positions and quaternions."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bt_manip import spatial


def test_a_quaternion_of_any_length_is_the_rotation_of_its_direction():
    for w, x, y, z in 3.0 * np.random.default_rng(0).normal(size=(10, 4)):
        T = spatial.pose((0.1, 0.2, 0.3), (1e-3 * w, 1e-3 * x, 1e-3 * y, 1e-3 * z))
        expected = Rotation.from_quat([x, y, z, w])
        np.testing.assert_allclose(T.rotation, expected.as_matrix(), atol=1e-12)
        again = Rotation.from_quat(np.roll(spatial.quat_wxyz(T), -1))
        assert (again * expected.inv()).magnitude() < 1e-7
        assert (
            spatial.cross(T.rotation[0], T.translation) == np.cross(T.rotation[0], T.translation)
        ).all()


def test_a_tool_that_points_down_is_turned_about_the_vertical():
    T = spatial.pointing_down((0.1, 0.2, 0.3), 0.4)
    assert T.rotation[:, 0] == pytest.approx([np.cos(0.4), np.sin(0.4), 0.0])
    assert T.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0])
    assert np.linalg.det(T.rotation) == pytest.approx(1.0)
    assert T.translation.tolist() == [0.1, 0.2, 0.3]
    assert spatial.pointing_down((0, 0, 0)).rotation == pytest.approx(np.diag([1.0, -1.0, -1.0]))


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_quaternion_that_is_not_finite_is_refused(number):
    with pytest.raises(ValueError, match="a quaternion is four finite numbers, not all zero, got"):
        spatial.pose((0.0, 0.0, 0.0), (number, 0.0, 0.0, 1.0))
    for position in ((0.0, number, 0.0), (0.0, 0.0)):
        with pytest.raises(ValueError, match="a position is three finite numbers"):
            spatial.pose(position)


def test_a_quaternion_of_zeros_is_refused():
    for size in (0.0, 9e-10):
        with pytest.raises(ValueError, match="not all zero"):
            spatial.pose((0.0, 0.0, 0.0), (0.0, size, 0.0, 0.0))
    T = spatial.pose((0.0, 0.0, 0.0), (0.0, 2e-9, 0.0, 0.0))
    assert T.rotation == pytest.approx(np.diag([1.0, -1.0, -1.0]))


def test_only_arrays_of_numbers_are_numbers():
    given = np.array([[1.5, 2.0], [3.0, 4.0]])
    for value in (given, given.tolist(), np.array([[1.5, 2], [3, 4]], np.float32)):
        found = spatial.as_numbers(value)
        assert (found == given).all() and found.dtype == float and found is not value
    for wrong in ("1", [1, "2"], [[1, 2], [3]], [True], None, [10**400]):
        assert np.isnan(spatial.as_numbers(wrong))
