"""Poses pass through text, on blackboards and in snapshots, and lose nothing."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.behaviours import pose_from_text, pose_to_text
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


def test_a_matrix_that_is_no_rotation_is_refused():
    for numbers in (
        "0;0;0;1;0;0;0;1;0;0;0;2",
        "0;0;0;1;0;0;0;1;0;0;0;-1",
        "0;0;0;" + "nan;" * 8 + "1",
    ):
        with pytest.raises(ValueError, match="a rotation matrix"):
            pose_from_text(numbers)
