"""Faults of the robot do what they say in the physics, and are undone."""

import numpy as np
import pytest

from bt_manip_stress import FaultError
from bt_manip_stress.faults.robot_faults import (
    Push,
    SensorDelay,
    SensorNaN,
    SensorNoise,
    StuckFinger,
    StuckJoint,
    TorqueLoss,
)


def test_a_push_moves_the_arm_until_it_ends(station, start):
    before = station.robot.tool_pose.translation
    fault = start(Push(force=50.0))
    station.cell.step(30)
    pushed = station.robot.tool_pose.translation - before
    force = station.cell.data.xfrc_applied[station.robot.wrist_body_id, :3]
    assert np.linalg.norm(force) == pytest.approx(50.0) and force[2] == 0.0
    assert pushed @ force > 1e-4 * np.linalg.norm(force)
    fault.end()
    assert not station.cell.data.xfrc_applied.any()


def test_pushes_have_all_horizontal_directions(station, start):
    force, angles = station.cell.data.xfrc_applied[station.robot.wrist_body_id], []
    for seed in range(30):
        fault = start(Push(), seed)
        angles.append(np.degrees(np.arctan2(force[1], force[0])))
        fault.end()
    assert np.diff(sorted([-180.0, *angles, 180.0])).max() < 50.0


def test_a_push_goes_on_after_a_compile(station, start):
    fault = start(Push(link="link4"))
    station.cell.remove("cube")
    fault.bind()
    body = station.cell.body_id("panda/link4")
    assert np.linalg.norm(station.cell.data.xfrc_applied[body]) == pytest.approx(100.0)


def test_a_stuck_joint_does_not_move_while_the_others_do(station, start):
    before = station.robot.q
    fault = start(StuckJoint(joint=2))
    station.arm.move_to_configuration(before + 0.3)
    station.cell.step(400)
    moved = np.abs(station.robot.q - before)
    assert moved[1] < 1e-5 < 1e-4 < moved[3]
    fault.end()
    assert not station.cell.overrides


def test_of_a_gripper_without_joints_none_can_be_stuck(start, monkeypatch):
    monkeypatch.setattr(
        StuckFinger, "dofs", lambda fault: fault.context.robot.robot.dof_adr.tolist()
    )
    for finger in (0, 1):
        with pytest.raises(FaultError, match=f"the gripper has 0 joints, got joint {finger}"):
            start(StuckFinger(finger=finger))


def test_a_stuck_finger_does_not_move(station, start):
    fault = start(StuckFinger(finger=1))
    joint = station.cell.model.joint("panda/finger_joint1").qposadr[0]
    before = station.cell.data.qpos[joint]
    station.gripper.close(50.0)
    station.cell.step(500)
    assert abs(station.cell.data.qpos[joint] - before) < 1e-3
    fault.end()
    station.cell.step(1000)
    assert abs(station.cell.data.qpos[joint] - before) > 0.01


def test_the_motors_of_the_arm_have_no_torque_and_the_gripper_has(station, start):
    fault = start(TorqueLoss())
    station.gripper.close(50.0)
    station.cell.step(100)
    assert np.abs(station.robot.tau).max() < 1e-6
    assert np.abs(station.cell.data.actuator_force).max() > 0.01
    fault.end()
    station.cell.step(1)
    assert np.abs(station.robot.tau).max() > 1.0


def test_controller_and_arm_measure_the_same_noise(station, start):
    true = station.cell.data.qpos[station.robot.qpos_adr].copy()
    fault = start(SensorNoise(position=0.1))
    seen = []
    controller = station.controller
    compute = controller.compute
    controller.compute = lambda q, *rest: (seen.append(q.copy()), compute(q, *rest))[1]
    try:
        station.arm.robot.read_q()
        measured = station.robot.q
        assert (station.robot.q == measured).all() and 0.01 < np.abs(measured - true).max() < 1.0
        station.cell.step(1)
        assert (seen[0] == measured).all()
    finally:
        del controller.compute
    noise = np.array([fault.measure(np.zeros(7), np.zeros(7)) for _ in range(300)])
    assert noise.std(axis=(0, 2)) == pytest.approx((0.1, 2e-3), rel=0.1)
    fault.end()
    now = station.cell.data.qpos[station.robot.qpos_adr]
    assert (station.robot.q == now).all()


def test_a_delayed_measurement_is_an_earlier_state(station, start):
    start(SensorDelay(delay=0.005))
    station.arm.move_to_configuration(station.robot.q + 0.3)
    true = []
    for _ in range(50):
        true.append(station.cell.data.qpos[station.robot.qpos_adr].copy())
        station.cell.step(1)
    assert (station.robot.q == true[-5]).all()


def test_a_sensor_fault_goes_on_after_a_compile_and_ends(station, start):
    fault = start(SensorNaN(joint=3))
    station.cell.remove("cube")
    fault.bind()
    assert np.flatnonzero(np.isnan(station.robot.q)).tolist() == [2]
    fault.end()
    assert np.isfinite(station.robot.q).all()


def test_without_a_number_any_joint_may_be_stuck(station, start):
    stuck = set()
    for seed in range(8):
        before = np.array(station.cell.nominal("panda", "joint_friction"))
        fault = start(StuckJoint(), seed=seed)
        after = np.array(station.cell.overrides["panda"]["joint_friction"])
        stuck.update(np.flatnonzero(after != before).tolist())
        fault.end()
    assert len(stuck) > 2


def test_links_and_joints_that_do_not_exist_and_two_faults_of_the_sensors_are_refused(start):
    with pytest.raises(FaultError, match="no body or entity is called 'panda/link44'"):
        start(Push(link="link44"))
    with pytest.raises(FaultError, match="the arm has 7 joints, got joint 8"):
        start(StuckJoint(joint=8))
    start(SensorNoise())
    with pytest.raises(FaultError, match="the sensors have a fault already"):
        start(SensorDelay())
