"""Real robots: the whole way to a fake arm in a process of its own."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from math import inf
from multiprocessing import Pipe
from pathlib import Path
from threading import Thread

import numpy as np
import pytest
from dm_control.composer.variation.distributions import Uniform

from bt_manip import build_station, load_plugins
from bt_manip.behaviours import MoveToConfiguration, Recover, WaitUntilUndisturbed
from bt_manip.bt import NodeStatus
from bt_manip.cell.randomization import Randomization
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.run_options import RunOptions
from bt_manip.cli.session import Session
from bt_manip.exceptions import BtManipError, MotionError
from bt_manip.plugins import PluginSelection
from bt_manip.robots import panda
from bt_manip.robots.connection_worker import serve_arm
from bt_manip.scenes import table_and_basket
from bt_manip_contracts import (
    DEVICE_CONTRACT,
    GRIPPER_CONTRACT,
    holds_an_object,
    recovers_from_a_problem,
)
from bt_manip_contracts.device_contract import stays_on_a_motion_to_its_end
from tests.measuring.tool_speeds import ToolPositions
from tests.support.program import DEVICES, run_python

FAKE = "fake=0.5"  # half of real time: a busy machine must not be taken for silence
SCENE = """
robots = [{name = "arm", position = [-0.1, 0.0, 1.015]}]
[[objects]]
model = "table"
[[objects]]
model = "basket"
on = "table"
position = [0.5, -0.1]
rpy = [0.0, 0.0, 1.5708]
[[objects]]
model = "cube"
on = "table"
position = [0.3, 0.1]
expected = true
"""
FRICTION = {"friction": Uniform(0.2, 0.6)}
RANDOMIZED = replace(table_and_basket(), randomization=Randomization(objects={"cube": FRICTION}))


@pytest.fixture(scope="module")
def parts():
    sys.path.append(str(DEVICES))
    choice = PluginSelection(folders=(DEVICES,))
    yield load_plugins(entry_points=(), choice=choice, warn=lambda text: None).parts
    sys.path.remove(str(DEVICES))


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return tmp_path_factory.mktemp("fake") / "rows.npy"


@pytest.fixture(scope="module")
def station(parts, file):
    station = build_station(
        parts, backend=f"{FAKE},{file}", controller="joint_impedance", speed=1.0, tool_speed=inf
    )
    yield station
    station.hardware.close()


@pytest.fixture
def reflex(station, file):
    problem = Path(f"{file}.problem")
    yield lambda text="joint_reflex, joint 4": problem.write_text(text)
    problem.unlink(missing_ok=True)
    steps(station, 20)


def steps(station, ticks):
    left = iter(range(ticks))
    station.step_until(lambda: next(left, None) is None, timeout=60.0, steps=10)


def set_off(station):
    """Move the first joint for a second or two; return its goal once it has moved by 0.1 rad."""
    arm = station.arm
    start = arm.q_ref
    goal = start + np.array([0.6 if start[0] < 0.5 else -0.6, 0, 0, 0, 0, 0, 0])
    arm.move_to_configuration(goal, speed=0.25)
    until(station, lambda: abs(arm.q[0] - start[0]) > 0.1)
    return goal


def until(station, condition):
    station.step_until(condition, steps=10)


def succeeds(station, node):
    result = station.run(node, timeout=20.0)
    return result.status is NodeStatus.SUCCESS


@pytest.mark.parametrize("check", DEVICE_CONTRACT, ids=lambda check: check.__name__)
def test_the_fake_arm_keeps_the_contract(station, check):
    check(station)


def test_the_fake_arm_recovers_from_a_problem(station, reflex):
    recovers_from_a_problem(station, reflex)


def test_a_reflex_in_a_motion_is_named_and_waiting_recovers_from_it(station, reflex):
    arm = station.arm
    set_off(station)
    reflex()
    until(station, lambda: not arm.moving)
    assert arm.fault == "the arm has stopped: joint_reflex, joint 4" and not arm.moving
    with pytest.raises(MotionError, match="does not move: joint_reflex, joint 4"):
        arm.move_to_configuration(arm.q_ref + 0.05)
    before = station.cell.time
    assert succeeds(station, WaitUntilUndisturbed())
    assert station.cell.time - before < 2.0
    goal = arm.q_ref + 0.05
    assert succeeds(station, MoveToConfiguration(configuration=goal.tolist()))


def test_recover_clears_an_error_and_does_nothing_without_one(station, reflex):
    assert succeeds(station, Recover())
    reflex()
    until(station, lambda: not station.arm.undisturbed)
    assert succeeds(station, Recover())
    assert station.arm.undisturbed


def test_a_paused_arm_goes_on_and_half_speed_takes_effect(station):
    arm = station.arm
    goal = set_off(station)
    arm.pause()
    until(station, lambda: not arm.moving and arm.at_rest)
    rests = arm.q_ref[0]
    assert arm.paused and abs(rests - goal[0]) > 0.1
    arm.speed_scale = 0.5
    until(station, lambda: abs(arm.q[0] - rests) > 0.1)
    arm.speed_scale = 1.0
    until(station, lambda: not arm.busy and arm.at_rest)
    np.testing.assert_allclose(station.robot.q, goal, atol=1e-3)
    assert not arm.fault


def test_an_external_force_stops_the_arm_without_making_it_compliant(station, file):
    arm, force = station.arm, Path(f"{file}.force")
    goal = set_off(station)
    force.touch()
    until(station, lambda: not arm.moving and arm.at_rest)
    force.unlink()
    assert arm.fault.startswith("external force on the arm: a torque of 30.0 N m")
    assert arm.at_rest and not arm.compliant and abs(arm.q[0] - goal[0]) > 0.1
    steps(station, 20)


def test_an_arm_that_is_moved_by_hand_is_named(station, file):
    station.arm.fault = ""
    Path(f"{file}.pushed").touch()
    until(station, lambda: station.arm.fault)
    assert station.arm.fault.startswith("the arm was moved: joint 2 by 0.1")
    steps(station, 2)  # the cell follows the readings a tick later
    np.testing.assert_allclose(station.arm.q, station.robot.q, atol=1e-6)


@pytest.fixture(scope="module")
def sagging(parts):
    """Give an arm that sags, measures no forces and has a gripper, with the defaults of speed."""
    backend = FAKE.replace("fake", "sagging")
    station = build_station(parts, backend=backend, controller="joint_impedance")
    yield station
    station.hardware.close()


def test_by_default_a_real_arm_moves_at_a_tenth_of_its_speed(sagging):
    arm = sagging.arm
    assert (arm.speed_factor, arm.speed_scale, arm.tool_speed) == (0.1, 1.0, 0.25)
    arm.move_to_configuration(arm.q_ref + 0.1)
    assert arm.remaining == pytest.approx(10.0 * arm.trajectory.nominal.duration, rel=0.1)
    arm.speed_factor = arm.speed_scale = 1.0
    until(sagging, lambda: not arm.busy and arm.at_rest)


def test_an_arm_that_sags_and_feels_nothing_works_with_a_gripper_on_its_connection(sagging):
    arm, gripper, hardware = sagging.arm, sagging.gripper, sagging.hardware
    assert "measures no external forces" in hardware.speeds
    assert hardware.report["external_forces"] == "unknown" and not arm.guard.measures
    arm.speed_factor = arm.speed_scale = 1.0
    goal = set_off(sagging)
    gripper.close(20.0)
    until(sagging, lambda: not arm.busy and arm.at_rest and not gripper.moving)
    assert gripper.width == 0.05 and not arm.fault
    np.testing.assert_allclose(arm.connection.latest.q_ref, goal, atol=1e-6)
    assert sagging.robot.q[1] == pytest.approx(goal[1] + 0.05, abs=1e-3)
    stays_on_a_motion_to_its_end(sagging)


@pytest.mark.parametrize("check", GRIPPER_CONTRACT, ids=lambda check: check.__name__)
def test_the_fake_gripper_keeps_the_contract(parts, check):
    from fake_arm import FakeGripper

    gripper = FakeGripper("")
    gripper.found = 0.0
    check(gripper, 0.08)


def test_the_contract_of_grippers_finds_one_that_claims_too_much(parts):
    from fake_arm import FakeGripper

    with pytest.raises(AssertionError, match="says that it grips something"):
        GRIPPER_CONTRACT[1](FakeGripper(""), 0.08)
    holds_an_object(FakeGripper(""), 0.08, 0.05)
    with pytest.raises(AssertionError, match="width=0.05"):
        holds_an_object(FakeGripper(""), 0.08, 0.03)


@pytest.mark.parametrize(
    ("request_fields", "message"),
    [
        ({"backend": "fake=1"}, "backend 'fake' has no controller 'computed_torque'"),
        ({"backend": "fak=1"}, "unknown backend 'fak'; did you mean 'fake'"),
        ({"backend": "fake"}, "--backend wants fake=ADDRESS"),
        ({"backend": "fake=1", "scene": "two_arms"}, "moves one robot, the scene has several"),
        ({"backend": "fake=1", "scene": RANDOMIZED}, "a real cell cannot be randomized"),
        ({"speed": 0.0}, "speed must be above 0"),
    ],
)
def test_impossible_requests_are_refused_with_a_reason(parts, request_fields, message):
    with pytest.raises(BtManipError, match=message):
        build_station(parts, **request_fields)


@pytest.mark.parametrize(
    ("factory", "message"),
    [
        ("fake_arm:FakeArm", "x: fake_arm:FakeArm failed: ValueError: could not convert"),
        ("fake_arm:NoArm", "x: fake_arm:NoArm failed: AttributeError"),
        ("no_module:Arm", "x: no_module:Arm failed: ModuleNotFoundError"),
    ],
)
def test_a_device_that_cannot_be_made_is_named_with_its_reason(parts, station, factory, message):
    here, there = Pipe()
    with here, there:
        serve_arm(there, b"", factory, "x", station.robot.limits)
        kind, text = here.recv()
    assert kind == "error" and text.startswith(message)


@pytest.fixture
def command(parts, tmp_path):
    """Give the command that runs a tree on the fake arm, and the file of references."""
    scene, setpoints = tmp_path / "scene.toml", tmp_path / "rows.npy"
    scene.write_text(SCENE)
    command = ["run", "pick_place", "--scene", scene, "--plugins-dir", DEVICES]
    return [*command, "--poses", "scene", "--backend", f"{FAKE},{setpoints}"], setpoints


PATH = os.pathsep.join([str(DEVICES), *sys.path])


def test_pick_place_runs_whole_on_the_fake_arm(command, tmp_path):
    arguments, setpoints = command
    options = ("--set", "height=0.2", "--speed", 1, "--report", tmp_path / "report.json")
    out = run_python("-m", "bt_manip", *arguments, *options, cwd=tmp_path, PYTHONPATH=PATH)
    assert "The arm moves at 100 % of its speed, its tool at most at 0.25 m/s." in out
    assert 0.24 < ToolPositions(panda()).speed(np.load(setpoints)) <= 0.25
    found = json.loads((tmp_path / "report.json").read_text())
    assert found["cycles"][0]["judged_by"] == "gripper and assumption"
    assert found["real"]["backend"] == "fake" and found["real"]["assumed"] == ["cube"]
    assert (found["real"]["speed"], found["real"]["tool_speed_m_s"]) == (1.0, 0.25)


def test_a_new_station_lets_the_arm_go_and_connects_to_it_again(command, tmp_path, monkeypatch):
    (_, _, _, scene, *_, backend), file = command
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(DEVICES))
    tree = tmp_path / "rest.xml"
    tree.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="T"><Sleep msec="20"/></BehaviorTree></root>'
    )
    options = RunOptions(tree=str(tree), scene=str(scene), poses="scene", backend=backend)
    session = Session(options, Interrupt())
    assert session.begin() == session.run(in_place=True) == 0
    assert not file.exists()  # it is written when the arm is let go
    assert session.run(in_place=False) == 0
    assert file.exists()
    assert session.has_station_of(session.last.run.request)
    session.station.hardware.close()


def when_it_moves(file):
    """Wait until the arm of a run moves; return the id of its process."""
    progress = Path(f"{file}.moving")
    for _ in range(6000):
        if progress.exists() and progress.read_text():
            return int(progress.read_text())
        time.sleep(0.01)
    raise AssertionError("the arm does not move")


@pytest.fixture
def run(command):
    """Start a run in a process of its own; give the process and the file once its arm moves."""
    arguments, file = command
    environment = os.environ | {"PYTHONPATH": PATH}
    whole = [sys.executable, "-m", "bt_manip", *map(str, arguments), "--speed", "0.3"]
    with subprocess.Popen(whole, env=environment) as process:
        when_it_moves(file)
        yield process, file
        process.kill()


def check_that_it_rests(file, limits):
    """Check that the arm comes to rest, and that references were inside the limits until then."""
    for _ in range(200):
        if file.exists():
            break
        time.sleep(0.05)
    setpoints = np.load(file)
    before = np.repeat(setpoints[:1], 3, axis=0)
    assert limits.setpoints_problem(before, setpoints) == ""
    speeds = np.abs(np.diff(setpoints, axis=0)).max(axis=1) / 1e-3
    assert speeds.max() > 0.1  # it was moving
    assert not speeds[-20:].any()  # and rests


MOMENTS = [0.6, *(pytest.param(t, marks=pytest.mark.soak) for t in np.linspace(0.01, 4.0, 20))]


@pytest.mark.parametrize("moment", MOMENTS)
def test_the_arm_rests_on_its_path_when_the_run_is_killed(run, station, moment):
    process, file = run
    time.sleep(moment)
    process.kill()
    check_that_it_rests(file, station.robot.limits)
    assert process.wait(20) == -signal.SIGKILL


@pytest.mark.soak
def test_the_arm_rests_on_its_path_when_the_run_is_interrupted(run, station):
    process, file = run
    time.sleep(0.6)
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 130
    check_that_it_rests(file, station.robot.limits)


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_run_whose_arm_process_is_killed_ends_at_once_and_names_it(bt_manip, command, moment):
    arguments, file = command
    killed = []

    def kill():
        arm = when_it_moves(file)
        time.sleep(moment)
        killed.append(time.monotonic())
        os.kill(arm, signal.SIGKILL)

    killer = Thread(target=kill)
    killer.start()
    done = bt_manip(*arguments, "--speed", 0.3)
    killer.join()
    assert time.monotonic() - killed[0] < 5.0
    assert done.code != 0
    assert "arm: its process has ended" in done.out + done.err and "Traceback" not in done.err
