"""The arm and its gripper against trossen-arm-sim, a simulator of their protocol by others."""

import numpy as np
import pytest

from bt_manip.robots import DeviceError
from bt_manip_contracts import GRIPPER_CONTRACT
from bt_manip_trossen import WidowXAI
from bt_manip_trossen.arm import Address

FAR = np.array([0.3, 0.3, 0.2, 0.0, 0.0, 0.0])  # [rad]
CYCLES = 300  # [2 ms] of a motion


@pytest.fixture
def arm(robot):
    arm = WidowXAI(robot.host)
    arm.connect()
    yield arm
    arm.close()


def move(arm, difference, during=lambda: None):
    """Move smoothly in 0.6 s of the arm's time; return the last state."""
    state = arm.read()
    start, begun, called = state.q_held, state.time, False
    while (cycle := round((state.time - begun) / arm.period)) < CYCLES and not state.problem:
        s = cycle / CYCLES
        arm.write(start + s**3 * (10 - 15 * s + 6 * s**2) * difference)
        state = arm.read()
        if cycle > CYCLES / 3 and not called:
            during()
            called = True
    for _ in range(100):
        arm.write(start + difference)
        state = arm.read()
    return state


def test_a_motion_arrives_reference_by_reference(robot, arm, tmp_path):
    before = arm.read().q_held
    robot.ask("save_references", file=str(tmp_path / "before.npy"))
    state = move(arm, FAR)
    assert not state.problem
    np.testing.assert_allclose(state.q, before + FAR, atol=5e-3)
    robot.ask("save_references", file=str(tmp_path / "all.npy"))
    time, q = np.split(np.load(tmp_path / "all.npy"), [1], axis=1)
    np.testing.assert_allclose(np.diff(time[:, 0]), arm.period, rtol=1e-6)
    v = np.diff(q, axis=0) / arm.period
    assert np.abs(v).max() == pytest.approx(1.875 * 0.3 / 0.6, rel=0.02)  # of the polynomial
    move(arm, -FAR)


def test_the_clock_of_readings_is_that_of_the_controller(robot, arm):
    times = [arm.read().time for _ in range(50)]
    assert (np.diff(times) > 0.9 * arm.period).all()
    assert np.median(np.diff(times)) == pytest.approx(arm.period)
    assert times[-1] == pytest.approx(robot.ask("arm")["time"], abs=0.1)


def test_a_fault_is_named_and_recovered_from(robot, arm):
    state = move(arm, FAR, lambda: robot.ask("fault", reason="joint 2 exceeded its limit"))
    assert "joint 2 exceeded its limit" in state.problem and state.recoverable
    assert state.q_held is None  # what the arm does without its controller, nobody holds
    arm.recover()
    assert not arm.read().problem
    assert not move(arm, -FAR / 2).problem


def test_a_lost_connection_is_named_and_built_up_anew(robot, arm):
    state = move(arm, FAR / 10, lambda: robot.ask("cut"))
    assert state.problem and state.recoverable
    robot.ask("restore")
    arm.recover()
    assert not move(arm, -FAR / 10).problem


def test_external_forces_may_be_unknown(robot):
    arm = WidowXAI(f"{robot.host}?external_forces=off")
    arm.connect()
    assert arm.read().tau_external is None
    arm.close()


@pytest.mark.parametrize("check", GRIPPER_CONTRACT, ids=lambda check: check.__name__)
def test_the_gripper_keeps_the_contract(arm, check):
    check(arm.gripper, 0.08)


def test_no_arm_is_refused_with_a_remedy():
    pytest.importorskip("trossen_arm")
    with pytest.raises(DeviceError, match="127.0.0.1: .*check the address"):
        WidowXAI("127.0.0.1").connect()


def test_an_address_has_options():
    address = Address.parse("192.168.1.2?end_effector=base&external_forces=off")
    assert address == Address("192.168.1.2", "base", "off")
    with pytest.raises(DeviceError, match="end_effector is one of follower, leader, base"):
        Address.parse("192.168.1.2?end_effector=hand")
