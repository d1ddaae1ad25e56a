"""Targets of inverse kinematics: what they accept and keep."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.kinematics import PoseTarget, PositionTarget, RotationTarget
from tests.measuring.kinematics import refused

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)


@pytest.mark.parametrize(
    "tolerance",
    [(1e-3,), (1e-3,) * 3, ([1e-3], [1e-3, 1e-3]), (1e-3, -1e-3), (1e-3, "wide"), (1.0, np.nan)]
    + [0.0, np.inf, 10**400, True, np.array("0.001"), {"position": 1e-3}],
)
def test_a_tolerance_of_a_pose_that_is_neither_a_number_nor_a_pair_is_refused(tolerance):
    refused(
        lambda: PoseTarget("tool", DOWN, tolerance=tolerance),
        "target of frame 'tool': tolerance must be above 0, or a pair of position and rotation",
    )


@pytest.mark.parametrize("tolerance", [(1e-3, 1e-3), [1e-3], "0.001", np.nan, 0.0])
def test_a_tolerance_of_a_position_or_a_rotation_is_one_number(tolerance):
    message = "frame 'tool': tolerance must be above 0, got"
    refused(lambda: PositionTarget("tool", np.zeros(3), tolerance=tolerance), message)
    refused(lambda: RotationTarget("tool", np.eye(3), tolerance=tolerance), message)


@pytest.mark.parametrize("pair", [(1e-3, 1e-2), [1e-3, 1e-2], np.array([1e-3, 1e-2])])
def test_a_pair_of_tolerances_may_be_any_kind_of_list(pair):
    assert PoseTarget("tool", DOWN, tolerance=pair).tolerances == (1e-3, 1e-2)


@pytest.mark.parametrize("weight", [0.0, np.nan, "1.0", [1.0], True])
def test_a_weight_is_a_number_above_zero(weight):
    refused(lambda: PoseTarget("tool", DOWN, weight=weight), "'tool': weight must be above 0, got")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PositionTarget("tool", [0.0, np.nan, 0.0]), "'tool': position must be 3 finite"),
        (lambda: PositionTarget("tool", ["0.1", "0.2", "0.3"]), "3 finite numbers .m., got"),
        (lambda: RotationTarget("tool", 2.0 * np.eye(3)), "'tool': rotation must be a 3 by 3"),
        (lambda: RotationTarget("tool", np.full((3, 3), np.nan)), "3 by 3"),
        (lambda: PoseTarget("tool", np.eye(4)), "'tool': pose must be a pin.SE3, got ndarray"),
        (lambda: PositionTarget(3, np.zeros(3)), "frame of a target must be a name, got 3"),
        (
            lambda: PositionTarget("tool", np.zeros(3), weight=1.0, tolerance=1.0),
            "must be a cost with",
        ),
    ],
)
def test_invalid_targets_are_refused_by_name(make, message):
    refused(make, message)


def test_a_target_is_a_copy(model):
    position = np.zeros(3)
    target = PositionTarget("tool", position)
    position[0] = 1.0
    assert target.position[0] == 0.0
    with pytest.raises(ValueError):
        target.position[0] = 2.0


@pytest.mark.parametrize("axis", ["z", [0.0, 0.0, 2.0], np.array([0, 0, 1])])
def test_a_free_axis_is_kept_as_a_unit_vector(axis):
    for target in (
        PoseTarget("tool", DOWN, free_axis=axis),
        RotationTarget("tool", DOWN.rotation, free_axis=axis),
    ):
        assert np.array_equal(target.free_axis, [0.0, 0.0, 1.0])
        with pytest.raises(ValueError):
            target.free_axis[0] = 1.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"free_axis": "w"}, "free_axis must be 'x', 'y', 'z' or a vector, got 'w'"),
        ({"free_axis": [0.0, 0.0, 0.0]}, "free_axis must not be zero"),
        ({"free_axis": [1.0, 0.0]}, "free_axis"),
        ({"free_axis": "z", "cone": 4.0}, r"cone must be from 0 to pi \[rad\], got 4.0"),
        ({"free_axis": "z", "cone": -0.1}, "cone must be from 0 to pi"),
        ({"cone": 0.1}, "a cone needs a free_axis, and no weight"),
        ({"free_axis": "z", "cone": 0.1, "weight": 1.0}, "a cone needs a free_axis, and no weight"),
        ({"pivot": [0.0, 0.0, 0.1]}, "a pivot needs a free_axis"),
    ],
)
def test_wrong_free_rotations_are_refused(given, message):
    refused(lambda: PoseTarget("tool", DOWN, **given), f"target of frame 'tool': .*{message}")
