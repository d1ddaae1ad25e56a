"""PD control by MuJoCo's actuators."""

import numpy as np
import pytest

from bt_manip.control import ComputedTorque, ControlError, ControllerManager
from bt_manip.robots import Payload
from bt_manip_learn import NativePD
from tests.support.arms import Wave

FACTORIES = {"native_pd": NativePD, "computed_torque": ComputedTorque}


@pytest.fixture
def managed(make_arm):
    return make_arm(ControllerManager, factories=FACTORIES, default="native_pd")


def test_the_actuators_apply_the_torques_of_the_law(make_arm):
    cell, robot, control = make_arm(NativePD, kp=(100, 10), kd=(7, 3))
    control.reference = Wave(robot.q, 0.2, 4.0)
    for _ in range(25):
        cell.step()
        np.testing.assert_allclose(robot.tau, control.tau, atol=1e-11)
    assert np.abs(control.tau).min() > 0.1


def test_its_feedforward_is_the_inverse_dynamics_of_the_reference_with_payload(make_arm):
    cell, robot, control = make_arm(NativePD)
    q, still = np.zeros(2), np.zeros(2)
    control.payload = Payload(0.3)
    tau = control.compute(q, still, q, still, still)
    # Centres of mass at 0.2 m, 0.4 + 0.15 m and 0.4 + 0.3 m; 2 kg, 1 kg and 0.3 kg.
    moments = [2 * 0.2 + 1 * 0.55 + 0.3 * 0.7, 1 * 0.15 + 0.3 * 0.3]
    np.testing.assert_allclose(tau, -9.81 * np.array(moments), atol=1e-9)


def test_another_controller_takes_over_and_hands_back_without_a_step_in_torque(managed):
    cell, robot, manager = managed
    manager.reference = Wave(robot.q, 0.2, 2.0)
    taus = []
    for name in ("native_pd", "computed_torque", "native_pd"):
        manager.switch(name)
        for _ in range(150):
            cell.step()
            np.testing.assert_allclose(robot.tau, manager.controller.tau, atol=1e-11)
            taus.append(robot.tau)
    changes = np.abs(np.diff(taus, axis=0)) / robot.limits.effort
    assert changes.max() < 0.02


def test_a_run_cannot_switch_to_it_because_its_gains_are_in_the_model(make_arm):
    *_, manager = make_arm(ControllerManager, factories=FACTORIES, default="computed_torque")
    with pytest.raises(ControlError, match="choose it as the first controller"):
        manager.switch("native_pd")


def test_a_restored_state_continues_with_the_same_bits(managed):
    cell, robot, manager = managed
    manager.reference = wave = Wave(robot.q, 0.2, 4.0)
    cell.step(13)
    snapshot = cell.snapshot()
    kept, t = manager.get_state(), wave.t
    cell.step(20)
    after = cell.data.qpos.tobytes()
    cell.restore(snapshot)
    manager.set_state(kept)
    wave.t = t
    wave.advance(0.0)
    cell.step(20)
    assert cell.data.qpos.tobytes() == after
