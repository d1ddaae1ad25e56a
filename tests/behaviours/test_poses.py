"""Poses pass through text and lose nothing; tool poses point down at objects."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.behaviours import (
    MoveToConfiguration,
    bottom_pose,
    centre_pose,
    downward_poses,
    nearest_orientation,
    pose_from_text,
    pose_to_text,
    top_grasp_poses,
)
from bt_manip.cell import Cell
from bt_manip.cell.objects import Box
from bt_manip.exceptions import PortError
from bt_manip.spatial import pose


def bits(T: pin.SE3) -> bytes:
    return T.rotation.tobytes() + T.translation.tobytes()


def test_a_pose_comes_back_to_the_last_bit():
    rng = np.random.default_rng(3)
    for _ in range(200):
        rotation = pin.Quaternion(rng.normal(size=4)).normalized().matrix()
        T = pin.SE3(rotation, rng.normal(size=3)) * pin.SE3.Random()
        assert bits(pose_from_text(pose_to_text(T))) == bits(T)


def test_simple_poses_stay_short():
    assert pose_to_text(pose((0.3, 0.0, 1.0))) == "0.3;0.0;1.0;1.0;0.0;0.0;0.0"
    assert bits(pose_from_text("0.3;-0.2;1")) == bits(pin.SE3(np.eye(3), np.array([0.3, -0.2, 1])))


def test_a_matrix_that_is_no_rotation_is_refused():
    for numbers in (
        "0;0;0;1;0;0;0;1;0;0;0;2",
        "0;0;0;1;0;0;0;1;0;0;0;-1",
        "0;0;0;0.5;0;0;0;0.5;0;0;0;0.5",
        "0;0;0;" + "nan;" * 8 + "1",
    ):
        with pytest.raises(ValueError, match="a rotation matrix"):
            pose_from_text(numbers)


def test_joints_as_text_are_numbers_or_the_name_of_a_configuration():
    assert MoveToConfiguration(configuration="above").given["configuration"] == "above"
    for text in ("0.1;above", " "):
        with pytest.raises(PortError, match="port 'configuration'"):
            MoveToConfiguration(configuration=text)


def test_tool_poses_over_a_box_that_lies_on_its_side_point_down_along_its_horizontal_axis():
    turned = pin.rpy.rpyToMatrix(-1.2, 0.0, 0.4)
    T_wo = pin.SE3(turned, np.array([0.3, -0.2, 0.1]))
    found = top_grasp_poses(T_wo, 0.07)
    for k, T_wt in enumerate(found):
        along = pin.exp3(np.array([0.0, 0.0, k * np.pi / 2])) @ turned[:, 0]
        np.testing.assert_allclose(T_wt.translation, [0.3, -0.2, 0.17])
        np.testing.assert_allclose(T_wt.rotation[:, [0, 2]].T, [along, [0, 0, -1]], atol=1e-12)
        near = T_wt * pin.SE3(pin.exp3(np.array([0.1, -0.2, 0.3])), np.array([0.5, 0.0, 0.0]))
        assert nearest_orientation(found, near) is T_wt
    for k, T_wt in enumerate(fifths := downward_poses((0.3, -0.2, 0.1), 5)):
        expected = pin.exp3(np.array([0.0, 0.0, 0.4 * np.pi * k])) @ fifths[0].rotation
        np.testing.assert_allclose(T_wt.rotation, expected, atol=1e-12)
        np.testing.assert_allclose(T_wt.translation, [0.3, -0.2, 0.1])


def test_the_centre_and_the_bottom_of_an_object_move_with_it():
    class Boot(Box):
        """A box whose origin is beside its centre."""

        centre_offset = np.array([0.01, -0.02, 0.03])

    cell, T_wo = Cell(), pose((0.3, -0.2, 0.9), (0.8, 0.3, -0.2, 0.5))
    boot = Boot(size=(0.04, 0.06, 0.08))
    cell.add(boot, T_wo, name="boot")
    for found, point in (
        (centre_pose(cell, "boot"), [0.01, -0.02, 0.03]),
        (bottom_pose(cell, "boot"), [0.01, -0.02, -boot.rest_height]),
    ):
        np.testing.assert_allclose(found.translation, T_wo.act(np.array(point)), atol=1e-12)
        np.testing.assert_allclose(found.rotation, T_wo.rotation, atol=1e-12)
