"""The arm and the hand against franka-sim, a server of Franka's protocol."""

import numpy as np
import pytest

from bt_manip.robots import DeviceError
from bt_manip_contracts import GRIPPER_CONTRACT

pytest.importorskip("pylibfranka")

from bt_manip_franka import FrankaArm, FrankaHand  # noqa: E402

FAR = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0])  # [rad]
CYCLES = 1000


@pytest.fixture
def arm(robot):
    arm = FrankaArm(robot.host)
    arm.connect()
    yield arm
    arm.close()


def move(arm, difference, during=lambda: None):
    """Move smoothly in 1 s of the robot's time; return the last state."""
    arm.start()
    state = arm.read()
    start, begun, called = state.q_held, state.time, False
    while (cycle := round((state.time - begun) / arm.period)) < CYCLES and not state.problem:
        s = cycle / CYCLES
        arm.write(start + s**3 * (10 - 15 * s + 6 * s**2) * difference)
        state = arm.read()
        if cycle > CYCLES / 3 and not called:
            during()
            called = True
    if not state.problem:
        arm.write(start + difference)
    arm.finish()
    return arm.read()


def test_a_motion_ends_where_the_last_reference_was(arm):
    before = arm.read().q_held
    state = move(arm, FAR)
    assert not state.problem
    np.testing.assert_allclose(state.q, before + FAR, atol=1e-3)
    move(arm, -FAR)


def test_a_reflex_is_named_with_its_joint_and_recovered_from(robot, arm):
    state = move(arm, FAR, lambda: robot.ask("reflex", joint=4))
    assert (state.problem, state.recoverable) == ("joint_reflex, joint 4", True)
    arm.recover()
    assert not arm.read().problem
    assert not move(arm, -FAR / 2).problem


def test_a_jump_of_the_reference_is_a_named_reflex(arm):
    arm.start()
    held = arm.read().q_held
    arm.write(held)
    arm.read()
    arm.write(held + 0.01)
    while not (state := arm.read()).problem:
        pass
    arm.finish()
    assert state.problem == "joint_motion_generator_velocity_discontinuity"
    arm.recover()


def test_a_user_stop_is_named_and_is_a_persons_to_release(robot, arm):
    state = move(arm, FAR, lambda: robot.ask("user_stop", pressed=True))
    assert state.problem.startswith("user_stop") and not state.recoverable
    arm.recover()
    assert arm.read().problem.startswith("user_stop")
    robot.ask("user_stop", pressed=False)
    assert any(not arm.read().problem for _ in range(100))  # after states that are on their way


def test_a_lost_connection_is_named_and_built_up_anew(robot, arm):
    state = move(arm, FAR, lambda: robot.ask("cut"))
    assert state.problem.startswith("connection lost") and state.recoverable
    arm.recover()
    assert not move(arm, FAR / 10).problem


def test_the_payload_is_refused_in_a_motion(arm):
    load = 0.1, np.zeros(3), np.eye(3) * 1e-4
    arm.set_payload(*load)
    arm.start()
    arm.read()
    with pytest.raises(DeviceError, match="between motions"):
        arm.set_payload(*load)
    arm.finish()


def test_another_version_is_refused_with_a_remedy(robot):
    robot.ask("set_version", version=5)
    try:
        with pytest.raises(DeviceError, match="server version: 5.*install the pylibfranka"):
            FrankaArm(robot.host).connect()
    finally:
        robot.ask("set_version", version=10)


def test_no_robot_is_refused_with_a_remedy():
    with pytest.raises(DeviceError, match="127.0.0.1: .*activate FCI"):
        FrankaArm("127.0.0.1").connect()


@pytest.mark.parametrize("check", GRIPPER_CONTRACT, ids=lambda check: check.__name__)
def test_the_hand_keeps_the_contract(robot, check):
    hand = FrankaHand(robot.host)
    hand.connect()
    hand.home()
    check(hand, 0.08)
    hand.close()
