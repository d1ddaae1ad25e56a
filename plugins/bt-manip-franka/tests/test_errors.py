"""libfranka's states as reasons, and addresses."""

from types import SimpleNamespace

import pytest

from bt_manip.robots import DeviceError
from bt_manip_franka import errors
from bt_manip_franka.address import Address


class Errors:
    """Errors as pylibfranka has them: properties of the class."""

    joint_reflex = property(lambda self: "joint_reflex" in self.found)
    cartesian_reflex = property(lambda self: "cartesian_reflex" in self.found)
    joint_position_limits_violation = property(
        lambda self: "joint_position_limits_violation" in self.found
    )

    def __init__(self, *found):
        self.found = found

    def __bool__(self):
        return bool(self.found)


def state(mode, *found, joint=0, axis=0):
    return SimpleNamespace(
        robot_mode=SimpleNamespace(name=mode),
        current_errors=Errors(*found),
        last_motion_errors=Errors(),
        joint_collision=[float(n == joint) for n in range(1, 8)],
        cartesian_collision=[float(n == axis) for n in range(1, 7)],
    )


@pytest.mark.parametrize(
    "found, expected",
    [
        (state("Idle"), ("", False)),
        (state("Move"), ("", False)),
        (state("Reflex", "joint_reflex", joint=4), ("joint_reflex, joint 4", True)),
        (state("Reflex", "cartesian_reflex", axis=3), ("cartesian_reflex, along z", True)),
        (
            state("Reflex", "joint_position_limits_violation"),
            ("joint_position_limits_violation", False),
        ),
    ],
)
def test_a_state_has_a_reason(found, expected):
    assert errors.problem(found) == expected


@pytest.mark.parametrize("mode", ["UserStopped", "Guiding", "Other"])
def test_a_mode_that_a_person_has_to_end_is_not_recoverable(mode):
    text, recoverable = errors.problem(state(mode))
    assert text and not recoverable


def test_an_address_has_options():
    address = Address.parse("fr3.local?realtime=enforce&collision_force=40")
    assert address == Address("fr3.local", "enforce", collision_force=40.0)
    assert address.enforces_realtime


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "no host"),
        ("?realtime=ignore", "no host"),
        ("fr3?realtim=ignore", "did you mean 'realtime'"),
        ("fr3?realtime=yes", "auto, enforce, ignore"),
        ("fr3?collision_force=-1", "between 0 and 1000"),
        ("fr3?collision_force=nan", "between 0 and 1000"),
    ],
)
def test_a_wrong_address_is_refused_with_what_would_be_right(text, message):
    with pytest.raises(DeviceError, match=message):
        Address.parse(text)
