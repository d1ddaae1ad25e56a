"""Targets of inverse kinematics: what they accept and keep."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.kinematics import PoseTarget, PositionTarget, RotationTarget
from tests.measuring.kinematics import refused

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)


OWN = "target of frame 'tool': "
PAIR = OWN + "tolerance must be above 0, or a pair of position and rotation"
CONE = "a cone needs a free_axis, and no weight"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        *(
            ({"tolerance": tolerance}, PAIR)
            for tolerance in ((1e-3,) * 3, (1e-3, -1e-3), (1e-3, "wide"), 0.0, True, 10**400)
        ),
        ({"weight": 0.0}, OWN + "weight must be above 0, got 0.0"),
        ({"weight": 1.0, "tolerance": 1.0}, "frame 'tool' must be a cost with"),
        ({"pose": np.eye(4)}, OWN + "pose must be a pin.SE3, got ndarray"),
        ({"frame": 3}, "frame of a target must be a name, got 3"),
        ({"free_axis": "w"}, OWN + "free_axis must be 'x', 'y', 'z' or a vector, got 'w'"),
        ({"free_axis": [0.0, 0.0, 0.0]}, OWN + "free_axis must not be zero"),
        ({"free_axis": [1.0, 0.0]}, OWN + "free_axis must be 3 finite numbers"),
        ({"free_axis": "z", "cone": 4.0}, OWN + r"cone must be from 0 to pi \[rad\], got 4.0"),
        ({"free_axis": "z", "cone": -0.1}, OWN + "cone must be from 0 to pi"),
        ({"cone": 0.1}, OWN + CONE),
        ({"free_axis": "z", "cone": 0.1, "weight": 1.0}, OWN + CONE),
        ({"pivot": [0.0, 0.0, 0.1]}, OWN + "a pivot needs a free_axis"),
    ],
)
def test_invalid_poses_are_refused_by_name(given, message):
    refused(lambda: PoseTarget(**{"frame": "tool", "pose": DOWN, **given}), message)


def test_invalid_positions_and_rotations_are_refused_by_name():
    for given in ({"tolerance": (1e-3, 1e-3)}, {"tolerance": 0.0}):
        for make, value in ((PositionTarget, np.zeros(3)), (RotationTarget, np.eye(3))):
            message = OWN + "tolerance must be above 0, got"
            refused(lambda m=make, v=value, g=given: m("tool", v, **g), message)
    refused(lambda: PositionTarget("tool", [0.0, np.nan, 0.0]), OWN + "position must be 3 finite")
    refused(lambda: RotationTarget("tool", 2.0 * np.eye(3)), OWN + "rotation must be a 3 by 3")


@pytest.mark.parametrize("pair", [[1e-3, 1e-2], np.array([1e-3, 1e-2])])
def test_a_pair_of_tolerances_may_be_any_kind_of_list(pair):
    assert PoseTarget("tool", DOWN, tolerance=pair).tolerances == (1e-3, 1e-2)


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
