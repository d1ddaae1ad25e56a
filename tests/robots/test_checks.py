"""Checks of arguments: what they accept, and what their messages say."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.robots import MotionLimits, checks


@pytest.mark.parametrize("value", [0.5, np.float64(0.5), np.float32(0.5), np.array(0.5)])
def test_every_kind_of_number_is_returned_as_a_float(value):
    for number in (checks.check_speed(value), checks.check_number(value, "angle", "rad")):
        assert type(number) is float and number == 0.5
    assert checks.check_positive(np.int32(3), "length", "m") == 3.0
    assert checks.check_non_negative(0.0, "margin", "rad") == 0.0
    assert [checks.check_count(n, "restarts") for n in (0, np.int64(3))] == [0, 3]


@pytest.mark.parametrize(
    ("check", "value"),
    [
        (checks.check_speed, 0.0),
        (checks.check_speed, 1.001),
        (lambda value: checks.check_positive(value, "tolerance", "m"), 0.0),
        (lambda value: checks.check_non_negative(value, "margin", "rad"), -1e-9),
        (lambda value: checks.check_count(value, "restarts"), -1),
        (lambda value: checks.check_count(value, "restarts"), 2.5),
    ],
)
def test_numbers_just_beyond_their_bounds_are_refused(check, value):
    with pytest.raises(MotionError, match="must be .*, got"):
        check(value)


@pytest.mark.parametrize("value", ["0.5", True, np.True_, np.array("0.5"), None, [0.5], np.nan, 1j])
@pytest.mark.parametrize("check", [checks.check_number, checks.check_count])
def test_text_booleans_and_lists_are_no_numbers(check, value):
    with pytest.raises(MotionError, match="must be .*, got") as raised:
        check(value, "steps")
    assert raised.value.reason == "target" and "\n" not in str(raised.value)


@pytest.mark.parametrize("value", [["0.1"] * 3, np.array(["0.1"] * 3, dtype=object), [True] * 3])
def test_a_vector_of_text_or_booleans_is_refused(value):
    with pytest.raises(MotionError, match=r"position must be 3 finite numbers \[m\], got"):
        checks.check_vector(value, "position", "m")


@pytest.mark.parametrize(
    ("bounds", "value", "message"),
    [
        ({}, np.inf, r"angle must be a finite number \[rad\], got inf"),
        ({"above": 0.0}, 0.0, r"angle must be above 0 \[rad\], got 0.0"),
        ({"at_least": 0.0}, -0.1, r"angle must be at least 0 \[rad\], got -0.1"),
        ({"above": 0.0, "at_most": 1.0}, 2, r"must be above 0 and at most 1 \[rad\], got 2"),
        ({"at_most": 1.0}, 2, r"must be at most 1 \[rad\], got 2"),
    ],
)
def test_a_message_says_the_bounds_the_unit_and_the_value(bounds, value, message):
    with pytest.raises(MotionError, match=message):
        checks.check_number(value, "angle", "rad", **bounds)


def test_long_values_are_shortened_in_messages():
    with pytest.raises(MotionError) as raised:
        checks.check_configuration(np.zeros(1000), 7)
    assert len(str(raised.value)) < 200


def test_every_rotation_of_the_exponential_map_is_returned_as_a_copy():
    for about in np.random.default_rng(0).normal(size=(20, 3)):
        R = pin.exp3(about)
        assert np.array_equal(checks.check_rotation(R), R) and checks.check_rotation(R) is not R
        for i in range(3):  # along each axis, 3e-6 rad and of the length are too much
            for by in (3e-6, -3e-6):
                for off in (
                    by * np.outer(np.eye(3)[i], R[i]),
                    by * np.outer(np.eye(3)[i], R[i - 1]),
                ):
                    with pytest.raises(MotionError, match="right-handed unit axes"):
                        checks.check_rotation(R + off)
    q = np.zeros(7)
    assert checks.check_configuration(q, 7) is not q


def test_a_pose_with_an_invalid_rotation_or_position_is_refused():
    T = pin.SE3.Identity()
    assert checks.check_pose(T) is T
    for diagonal in ([1.0, 1.0, -1.0], [0.5, 1.0, 0.5], [1.0, 0.5, 0.5]):
        with pytest.raises(MotionError, match="right-handed unit axes"):
            checks.check_pose(pin.SE3(np.diag(diagonal), np.zeros(3)))
    with pytest.raises(MotionError, match="right-handed unit axes"):
        checks.check_pose(pin.SE3(np.full((3, 3), np.nan), np.zeros(3)))
    for axis in np.eye(3, dtype=bool):
        with pytest.raises(MotionError, match="position of the pose must be finite"):
            checks.check_pose(pin.SE3(np.eye(3), np.where(axis, np.inf, 0.0)))


def test_the_first_joint_outside_its_limits_is_named():
    one = np.ones(3)
    limits = MotionLimits(-one, one, one, one, one, one)
    beyond = 1.0 + np.array([9e-7, -0.5, 1e-7])  # by rounding only
    assert limits.checked(beyond).tolist() == [1.0, 0.5, 1.0]
    assert limits.checked(-beyond).tolist() == [-1.0, -0.5, -1.0]
    with pytest.raises(MotionError, match="joint 1 cannot go to 1.0000 rad"):
        limits.checked(one + [2e-6, 0.0, 0.0])
    with pytest.raises(MotionError, match="joint 2 cannot go to 1.5000 rad: its limits are -1.0"):
        limits.checked(np.array([0.0, 1.5, -2.0]))
