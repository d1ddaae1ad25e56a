"""Joints of almost no inertia are held by computed torque, PD control and after a fault."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station, spatial
from bt_manip.control.computed_torque import added_inertia
from bt_manip.control.exceptions import ControllerFault
from bt_manip.control.pd_law import default_gains
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, compile_alone, panda, read_description
from bt_manip.runner import Station
from tests.support.small_arm import write_small_arm


def light_station(parts, folder, **request: str) -> Station:
    light = write_small_arm(folder, armature=0.0, friction=0.0, damping=0.0)
    return build_station(parts, robot=str(light), **request)


def test_a_light_arm_deflects_little_while_it_grips_a_cube_off_its_middle(parts, tmp_path):
    station = light_station(parts, tmp_path)
    arm, cell = station.arm, station.cell
    station.gripper.open()
    arm.move_to_pose([spatial.pointing_down((0.12, 0.2, 1.06), k * np.pi / 2) for k in range(4)])
    station.step_until(lambda: not arm.busy and station.gripper.is_open)
    x, y, _ = arm.model.pose(arm.q).act(np.array([0.0, 0.01, 0.0]))
    cell.add(station.models.create("cube"), spatial.pose((x, y, 1.04)), name="cube")
    cell.step(100)
    station.gripper.close(50.0)
    for _ in range(600):
        cell.step()
        assert np.abs(arm.q - station.robot.q).max() < 0.03
    assert station.gripper.held == ("cube",)


def model_of(description):
    robot = Robot(description, gripper=TwoFingerGripper)
    compile_alone(robot)
    return robot.make_model()


def test_nothing_is_added_to_the_inertia_of_usual_arms_and_gains_follow_their_effort(tmp_path):
    model = model_of(panda())
    assert not added_inertia(model).any()
    assert not added_inertia(model_of(read_description(write_small_arm(tmp_path)))).any()
    kp, kd = default_gains(model)
    assert kp == pytest.approx(15.0 * model.limits.effort)
    assert kd == pytest.approx(0.6 * model.limits.effort)


def test_the_added_inertia_keeps_the_ratio_that_the_control_step_allows(tmp_path):
    model = model_of(read_description(write_small_arm(tmp_path, armature=0.0)))
    added = np.diag(added_inertia(model))
    assert added.any()
    rng, largest, smallest = np.random.default_rng(5), [], []
    for q in rng.uniform(model.limits.lower, model.limits.upper, (50, model.nq)):
        inertia = pin.crba(model.model, model.data, q)
        ratios = np.linalg.eigvals(np.linalg.solve(inertia, inertia + added)).real
        largest.append(ratios.max())
        smallest.append(1.0 / np.linalg.inv(inertia)[5, 5])
    assert 6.0 < max(largest) < 12.0  # about 8
    kp, kd = default_gains(model)
    assert kd[5] == pytest.approx(500.0 * min(smallest), rel=0.3)
    assert kp == pytest.approx(25.0 * kd)
    model = model_of(read_description(write_small_arm(tmp_path, armature=0.004)))  # less light
    inertia = 1.0 / np.diag(np.linalg.inv(pin.crba(model.model, model.data, model.home)))
    assert (inertia + added_inertia(model))[[0, 5]] == pytest.approx(8e-4 * 12.0, rel=1e-3)


def still_after_a_push(station: Station) -> bool:
    """Return whether the arm rests where it was, half a second after it got a velocity."""
    q = station.robot.q
    station.cell.data.qvel[station.robot.dof_adr] = 0.1
    for _ in range(50):
        station.cell.step(10)
    return np.abs(station.robot.q - q).max() < 0.02 and np.abs(station.robot.v).max() < 0.02


def test_pd_control_of_a_light_arm_is_stable(parts, tmp_path):
    assert still_after_a_push(light_station(parts, tmp_path, controller="gravity_compensated_pd"))


def test_what_replaces_a_failed_controller_holds_a_light_arm(parts, tmp_path, monkeypatch):
    station = light_station(parts, tmp_path)
    monkeypatch.setattr(station.controller, "compute", lambda q, *_: np.full_like(q, np.nan))
    with pytest.raises(ControllerFault):
        station.cell.step()
    assert still_after_a_push(station)
