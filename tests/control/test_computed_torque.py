"""Computed torque agrees with MuJoCo's dynamics and has linear error dynamics."""

import mujoco
import numpy as np
import pytest

from bt_manip.control import ComputedTorque, ControlError
from bt_manip.robots import Payload, Robot

from .conftest import Wave


def test_the_torque_gives_mujoco_the_commanded_acceleration(make_arm):
    cell, robot, control = make_arm(ComputedTorque)
    model, data = cell.model, cell.data
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    control.bare_model.friction[:] = 0
    control.payload = None  # makes the model anew
    rng = np.random.default_rng(1)
    for _ in range(20):
        q, v, a = rng.normal(size=(3, 2))
        data.qpos[robot.qpos_adr], data.qvel[robot.dof_adr] = q, v
        data.ctrl[robot.ctrl_adr] = 0
        data.qfrc_applied[robot.dof_adr] = control.compute(q, v, q, v, a)
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(data.qacc[robot.dof_adr], a, atol=1e-9)


def test_damping_is_compensated_as_measured_and_dry_friction_as_commanded(make_arm):
    cell, robot, control = make_arm(ComputedTorque)
    q, v, v_ref = np.array([[0.4, -0.7], [0.3, -0.5], [0.01, -0.005]])
    robot.set_configuration(q)
    cell.data.qvel[robot.dof_adr] = v
    mujoco.mj_forward(cell.model, cell.data)
    expected = cell.data.qfrc_bias[robot.dof_adr] + np.array([0.3, 0.1]) * v
    expected += np.array([0.2, 0.1]) * np.tanh(v_ref / 0.01)
    undone = -120.0 * (v_ref - v)  # the feedback on the velocity
    assert control.compute(q, v, q, v_ref, undone) == pytest.approx(expected)
    for gains in zip(control.kd, control.kp, control.ki, strict=True):  # poles at -40 rad/s
        assert gains == pytest.approx(tuple(np.poly([-40.0] * 3)[1:]))


def test_the_error_of_every_joint_follows_the_linear_equation(make_arm):
    """e'' + kd e' + kp e + ki z = 0, z' = e, integrated here step by step as MuJoCo does."""
    cell, robot, control = make_arm(ComputedTorque, kp=(300, 1200), ki=(1000, 8000), kd=(30, 60))
    cell.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    # MuJoCo takes joint damping implicitly; without it the equation is exact.
    cell.model.dof_damping[:] = 0
    control.bare_model.damping[:] = 0
    control.bare_model.friction[:] = 0
    control.payload = None  # makes the model anew
    start = robot.q
    control.reference.q = start + np.array([0.02, -0.03])
    e, edot, z = np.array([0.02, -0.03]), np.zeros(2), np.zeros(2)
    for _ in range(300):
        cell.step()
        acceleration = -(control.kp * e + control.kd * edot + control.ki * z)
        z = z + e * cell.dt
        edot = edot + acceleration * cell.dt
        e = e + edot * cell.dt
        np.testing.assert_allclose(control.reference.q - robot.q, e, atol=2e-7)


def test_a_fast_reference_is_followed_to_a_milliradian(make_arm):
    cell, robot, control = make_arm(ComputedTorque)
    wave = Wave(robot.q, amplitude=0.2, rate=6.0)  # up to 7.2 rad/s2
    control.reference = wave
    worst = 0.0
    for _ in range(1000):
        cell.step()
        assert wave.t == pytest.approx(cell.time)
        worst = max(worst, np.abs(robot.q - wave.q).max())
    assert worst < 1e-3
    assert control.saturated_steps == 0


def test_the_integral_does_not_wind_up_while_a_joint_is_saturated(make_arm):
    """After a tenth of a second of saturation the arm returns without a large overshoot."""
    cell, robot, control = make_arm(ComputedTorque)
    home = robot.q
    cell.model.opt.gravity[:] = 0
    cell.data.qfrc_applied[robot.dof_adr] = (-60.0, 0.0)  # more than the shoulder's 40 N m
    cell.step(100)
    assert control.saturated_steps > 90
    cell.data.qfrc_applied[:] = 0
    overshoot = 0.0
    for _ in range(1500):
        cell.step()
        overshoot = max(overshoot, robot.q[0] - home[0])
    sunk = control.get_state()["integral"]
    assert abs(sunk[0]) < 0.05
    assert overshoot < 0.6
    np.testing.assert_allclose(robot.q, home, atol=1e-3)


def test_a_payload_adds_its_weight_times_the_lever(make_arm):
    cell, robot, control = make_arm(ComputedTorque)
    still = np.zeros(2)
    q = np.zeros(2)  # both links level: levers 0.7 m and 0.3 m
    empty = control.compute(q, still, q, still, still).copy()
    control.payload = Payload(0.5)
    loaded = control.compute(q, still, q, still, still)
    # Positive rotation about y lowers the arm, so that holding is negative.
    np.testing.assert_allclose(loaded - empty, [-0.5 * 9.81 * 0.7, -0.5 * 9.81 * 0.3], atol=1e-9)
    control.payload = None
    np.testing.assert_array_equal(control.compute(q, still, q, still, still), empty)


def test_the_payload_of_the_reference_is_taken_over_also_right_after_a_state_is_restored(make_arm):
    cell, robot, control = make_arm(ComputedTorque)
    control.reference = wave = Wave(robot.q, 0.0, 1.0)
    wave.payload = Payload(0.5)
    cell.step()
    assert control.payload is wave.payload
    state = control.get_state()
    for payload in (Payload(0.5), None):
        wave.payload = None
        cell.step()
        assert control.payload is None
        control.set_state(state)
        wave.payload = payload
        cell.step()
        assert control.payload is payload


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"kp": (1, 2, 3)}, "kp is one number, or one for each of 2 joints"),
        ({"ki": -1}, "ki must be finite and not negative"),
        ({"kd": float("nan")}, "kd must be finite"),
    ],
)
def test_invalid_gains_are_refused(description, gains, message):
    with pytest.raises(ControlError, match=message):
        ComputedTorque(Robot(description), **gains)


@pytest.mark.parametrize("q", [np.zeros(2, dtype=np.float32), np.zeros(3)])
def test_a_reference_of_another_shape_or_type_is_refused(make_arm, q):
    cell, robot, control = make_arm(ComputedTorque)
    wave = Wave(robot.q, 0.1, 1.0)
    wave.q = q
    with pytest.raises(ControlError, match="2 numbers of type float64"):
        control.reference = wave
    cell.step()
