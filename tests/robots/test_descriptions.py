from dataclasses import replace

import numpy as np
import pytest

from bt_manip.robots import JointLimits, Payload, RobotError, panda

ONE, TABLE = np.ones(2), np.ones((2, 2))


def limits(**changes):
    arrays = dict(lower=-ONE, upper=ONE, velocity=ONE, acceleration=ONE, jerk=ONE, effort=ONE)
    return JointLimits(**{**arrays, **changes})


def test_joint_limits_are_copied_and_cannot_be_written():
    source = ONE.copy()
    made = limits(velocity=source)
    source[0] = 9.0
    assert made.velocity[0] == 1.0
    with pytest.raises(ValueError):
        made.velocity[0] = 2.0


@pytest.mark.parametrize(
    "wrong",
    [
        dict(lower=ONE, upper=-ONE),
        dict(velocity=np.zeros(2)),
        dict(effort=np.ones(3)),
        dict(effort=np.float64(1.0)),
        dict(
            lower=-TABLE,
            **dict.fromkeys(("upper", "velocity", "acceleration", "jerk", "effort"), TABLE),
        ),
        dict(jerk=np.full(2, np.nan)),
    ],
)
def test_impossible_joint_limits_are_refused(wrong):
    with pytest.raises(RobotError, match="joint limits"):
        limits(**wrong)


def test_a_payload_goes_through_plain_data_unchanged():
    payload = Payload(0.5, [0.0, 0.01, 0.02], np.diag([1e-3, 2e-3, 3e-3]))
    again = Payload.from_state(payload.get_state())
    assert again.mass == payload.mass
    assert np.array_equal(again.com, payload.com)
    assert np.array_equal(again.inertia, payload.inertia)


@pytest.mark.parametrize(
    "wrong", [dict(mass=-1.0), dict(mass=np.nan), dict(mass=1.0, com=[0, 0]), dict(mass=np.inf)]
)
def test_an_impossible_payload_is_refused(wrong):
    with pytest.raises(RobotError, match="payload"):
        Payload(**wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (dict(tool_limits=(0.1, 1, 10)), r"'tool_limits' is a table, got \(0.1, 1, 10\)"),
        (dict(gripper={}), "'gripper' is a table, got {}"),
        (dict(velocity=0.5), "'velocity' is a list of numbers, got 0.5"),
        (dict(velocity=(0.5,) * 6), "'velocity' is a list of 7 numbers, got 6"),
        (dict(velocity=(np.inf,) * 7), "'velocity' is a finite number"),
        (dict(home=(np.nan,) * 7), "'home' is a finite number"),
        (dict(jerk=(-1.0,) * 7), "'jerk' is a positive number .rad/s3."),
        (dict(tool_speed="fast"), "'tool_speed' is a number, got 'fast'"),
    ],
)
def test_an_impossible_value_is_refused_by_its_key(wrong, message):
    with pytest.raises(RobotError, match=f"robot 'panda': key {message}"):
        replace(panda(), **wrong)
