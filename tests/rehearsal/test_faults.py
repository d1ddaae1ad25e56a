"""Faults of the real cell in the middle of a run: each is named, and recovered from."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from cell_operator import Operator

RECOVERY = 2.0  # [s] of the robot's clock, from the end of a fault until the arm moves again
TIMEOUT = 1.0  # [s] without an answer after which libfranka takes a connection for lost
FAR = 0.2  # [rad] by which a person moves a joint
HOLD = "import sys; from bt_manip_franka import FrankaArm; arm = FrankaArm(sys.argv[1])"
HOLD += "; arm.connect(); print(flush=True); sys.stdin.read()"


@pytest.fixture(scope="module")
def cell_robot(start_robot, real):
    """A robot in the real cell, in which each test takes the first cube."""
    return start_robot(real[0], "--patient")


@pytest.fixture
def run(cell_robot, scene, real):
    """A run of one cycle in the real cell, which is ended with the test."""
    run = Operator(cell_robot, scene, real[1])
    yield run
    run.process.kill()
    run.process.wait()


@pytest.fixture(scope="module", autouse=True)
def refused(start_robot, scene, real):
    """A run on a robot that another client uses, begun early because it waits long."""
    robot = start_robot()
    other = subprocess.Popen(
        [sys.executable, "-c", HOLD, robot.host], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert other.stdout.readline()
    run = Operator(robot, scene, real[1])
    yield run
    for process in (run.process, other):
        process.kill()
        process.wait()


def succeeds_in_spite_of(run, *texts):
    """Check that a run names faults and goes on to the end."""
    assert run.end() == 0, run.output
    assert all(text in " ".join(run.output.split()) for text in texts), run.output
    assert "Traceback" not in run.output
    assert run.placed == ["cube_1"]


def moving(robot, run):
    """Wait until the arm moves."""
    try:
        robot.until(lambda arm: np.abs(arm["v"]).max() > 0.1, 30.0)
    except AssertionError:
        raise AssertionError(f"the arm does not move; {run.rest()}") from None


def moves_again(robot, run, fault, within=RECOVERY, **arguments):
    """Bring about or end a fault; check that the arm moves soon after, by the robot's clock."""
    begun = robot.ask("arm")["time"]
    robot.ask(fault, **arguments)
    robot.until(lambda arm: np.abs(arm["v"]).max() < 0.01, 30.0)
    moving(robot, run)
    after = robot.ask("arm")["time"] - begun
    print(f"{fault}: the arm moves again after {after:.2f} s")
    assert after < within


def test_a_reflex_and_later_a_cut_connection_are_named_and_recovered_from(cell_robot, run):
    run.until("OpenGripper")
    moving(cell_robot, run)
    moves_again(cell_robot, run, "reflex", joint=4)
    run.until("OpenGripper.*OpenGripper")  # the next attempt
    moving(cell_robot, run)
    moves_again(cell_robot, run, "cut", within=TIMEOUT + RECOVERY)
    succeeds_in_spite_of(run, "joint_reflex, joint 4", "connection lost")


def test_an_arm_moved_by_hand_before_the_start_is_named_and_a_user_stop_until_its_release(
    cell_robot, run
):
    def push():
        q = cell_robot.ask("arm")["q"]
        cell_robot.ask("move_by_hand", q=[q[0] + FAR, *q[1:]])
        time.sleep(0.5)

    run.before_answer = push
    run.until("OpenGripper")
    moving(cell_robot, run)
    cell_robot.ask("user_stop", pressed=True)
    run.until("user_stop")
    time.sleep(1.0)
    moves_again(cell_robot, run, "user_stop", pressed=False)
    succeeds_in_spite_of(run, "joint 1", "user_stop")


def test_a_slipped_object_is_approached_again_and_the_arm_stops_when_the_tree_is_killed(
    cell_robot, run
):
    run.until("Lift: arrived")
    run.put("cube_1")  # back to where it was
    run.until("'cube_1' was lost during the motion.*Hover: arrived")
    moving(cell_robot, run)
    os.kill(run.process.pid, signal.SIGKILL)
    cell_robot.until(lambda arm: np.abs(arm["v"]).max() < 0.02, 10.0)
    assert cell_robot.ask("errors") == []
    assert "Traceback" not in run.rest()


def test_another_client_is_named(refused):
    assert refused.end() == 2, refused.output
    assert "no other client connected" in " ".join(refused.output.split()), refused.output
    assert "Traceback" not in refused.output
