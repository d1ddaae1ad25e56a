"""Reasons of faults name the cause."""

import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from bt_manip.arm import diagnosis
from bt_manip.arm.diagnosis import diagnose
from bt_manip.arm.external_force_guard import Detection, ExternalLoad, torque_thresholds
from bt_manip.control import gravity_compensated_pd
from bt_manip.control.pd_law import default_gains
from bt_manip.robots import Payload
from tests.measuring.collisions import one_arm

THERE = np.array([0.6, -0.3, 0.3, -2.0, 0.2, 1.8, 0.4])


@pytest.fixture(scope="module")
def built(parts):
    """Give a station whose arm has moved for 250 steps of a motion."""
    station = one_arm("computed_torque", parts)
    station.arm.move_to_configuration(THERE)
    station.cell.step(250)
    assert not station.arm.fault
    return station, station.get_state()


def fault(station, steps=500):
    for _ in range(steps):
        station.cell.step()
        if station.arm.fault:
            break
    return station.arm.fault


@pytest.mark.parametrize(
    ("body", "where"),
    [("hand", "the tool|link 7"), ("link6", "link 6|link 7|the tool"), ("link4", "link 4")],
)
def test_push_is_named_with_force_direction_and_link(station, body, where):
    push = np.array([88.0, -43.0, 23.0])
    station.cell.data.xfrc_applied[station.cell.body_id(f"panda/{body}")][:3] = push
    found = re.search(r"about (\d+) N towards \((\S+), (\S+), (\S+)\) at (.*)$", fault(station))
    assert found, station.arm.fault
    size, *direction = map(float, found.groups()[:4])
    assert np.linalg.norm(size * np.array(direction) - push) < 0.3 * np.linalg.norm(push)
    assert re.fullmatch(where, found.group(5))


@pytest.mark.parametrize("share", [0.02, 30.0])
def test_weak_or_chattering_controller_is_said_not_to_follow(parts, share, monkeypatch):
    def shared(model):
        return [share * gain for gain in default_gains(model)]

    monkeypatch.setattr(gravity_compensated_pd, "default_gains", shared)
    station = one_arm("gravity_compensated_pd", parts)
    arm = station.arm
    arm.move_to_configuration(THERE)
    reason = fault(station, 2500) or arm.describe_error()
    assert re.fullmatch(
        r"the controller does not follow: joint \d is 0\.\d+ rad off its reference and nothing "
        r"touches the arm",
        reason,
    )


def test_lost_torque_of_a_joint_is_no_external_force(station, monkeypatch):
    compute = station.controller.compute

    def without_second_joint(*state):
        return np.where(np.arange(7) == 1, 0.0, compute(*state))

    monkeypatch.setattr(station.controller, "compute", without_second_joint)
    assert fault(station).startswith("the controller does not follow: joint")


@pytest.mark.parametrize(("reading", "name"), [("read_q", "position"), ("read_v", "velocity")])
def test_sensor_that_reads_nan_is_named_and_the_arm_stops(station, monkeypatch, reading, name):
    robot, arm = station.robot, station.arm
    read = getattr(robot, reading)
    monkeypatch.setattr(robot, reading, lambda: np.where(np.arange(7) == 2, np.nan, read()))
    assert fault(station, 20) == f"the measured {name} of joint 3 is nan"
    station.cell.step(300)
    monkeypatch.undo()
    assert not arm.moving and np.abs(robot.q - arm.q).max() < 0.05


@pytest.mark.parametrize(("inside", "blamed"), [(0.9e-3, "controller"), (1.1e-3, "external")])
def test_the_torque_of_a_joint_at_its_limit_is_no_external_force(
    station, monkeypatch, inside, blamed
):
    arm, limits, q = station.arm, station.arm.model.limits, station.robot.q
    thresholds = torque_thresholds(arm.model)
    load = Detection(ExternalLoad(2.0 * thresholds * np.eye(7)[3], thresholds))
    for end in ({"lower": q - inside}, {"upper": q + inside}):
        monkeypatch.setattr(arm, "model", arm.model.with_limits(replace(limits, **end)))
        assert blamed in diagnose(arm, load)[:15]


def test_time_step_that_has_changed_is_named(station):
    station.cell.model.opt.timestep = 0.002
    try:
        assert fault(station) == "the time step has changed from 1 to 2 ms"
    finally:
        station.cell.model.opt.timestep = 0.001


def torques_of(station, body, force):
    """Torques of a force at a body's centre of mass, or at the tool, by MuJoCo."""
    model, data = station.cell.model, station.cell.data
    jacobian = np.zeros((3, model.nv))
    if body == "tool":
        mujoco.mj_jacSite(model, data, jacobian, None, model.site("panda/tool").id)
    else:
        mujoco.mj_jacBodyCom(model, data, jacobian, None, model.body(f"panda/{body}").id)
    return force @ jacobian[:, list(station.robot.dof_adr)]


THRESHOLDS = np.array([8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0])


def test_a_force_is_computed_from_the_torques_at_the_joints_before_it(station):
    for body, end in (("link4", "N|link 4"), ("link5", "N s|link 5"), ("tool", "N|the tool")):
        tau, (unit, named) = torques_of(station, body, [120.0, -210.0, 70.0]), end.split("|")
        load = ExternalLoad(tau, THRESHOLDS, unit == "N s")
        force = f"about 250 {unit} towards (0.48, -0.83, 0.28) at {named}"
        reason = diagnose(station.arm, Detection(load))
        assert reason == f"external force on the arm: {load}; {force}"
    for values, named in (
        ([0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.9], "only joint 4 is loaded"),
        ([40.0, -40.0, 0.0, 40.0, 2.1, 0.0, 0.9], "it acts on link 5 or beyond"),
    ):
        load = Detection(ExternalLoad(np.array(values), THRESHOLDS))
        assert diagnose(station.arm, load).endswith(f"; {named}")


def test_an_unknown_payload_is_weighed_while_the_arm_accelerates(station, monkeypatch):
    arm, robot = station.arm, station.robot
    monkeypatch.setattr(arm, "payload", Payload(0.5))
    h, q, v, a = 1e-5, robot.q, robot.v, np.array([3.0, -4.0, 2.0, 5.0, 1.0, -6.0, 2.0])
    monkeypatch.setattr(robot, "read_a", lambda: a)
    path = (arm.model.pose(q + t * v + 0.5 * t * t * a).translation.copy() for t in (-h, 0.0, h))
    fall = np.array([0.0, 0.0, -9.81]) - np.diff([*path], 2, axis=0)[0] / h**2
    aside = np.cross(fall, [0.3, -0.5, 0.8])
    aside *= np.linalg.norm(fall) / np.linalg.norm(aside)

    def weighed(tau):
        load = ExternalLoad(tau, THRESHOLDS)
        monkeypatch.setattr(diagnosis, "external_load", lambda *_: load)
        return "weighs about 4.5 kg, 0.5 kg were assumed" in diagnose(arm, Detection(load))

    for angle in (-0.31, -0.29, 0.0, 0.29, 0.31):
        force = 4.0 * (fall + np.tan(angle) * aside)
        assert weighed(torques_of(station, "tool", force)) == (abs(angle) < 0.3)
    # What no force at the tool explains, beyond half a threshold, is at most a quarter of all.
    levers = torques_of(station, "tool", np.eye(3)) / THRESHOLDS
    base, beside = 4.0 * fall @ levers, np.linalg.svd(levers)[2][-1]
    beside /= np.abs(beside).max()
    for size in np.linspace(0.0, 6.0, 61):
        share = (size - 0.5) / np.abs(base + size * beside).max()
        assert weighed((base + size * beside) * THRESHOLDS) == (share <= 0.25)
