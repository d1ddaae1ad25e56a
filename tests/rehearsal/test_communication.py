"""Motions that are planned while the arm moves: cycles without a reference, and violations.

MINUTES=10 .venv/bin/python tools/rehearsal.py -m soak -k communication -s
"""

import os
import subprocess
import sys
import time
from collections import Counter

import numpy as np
import pinocchio as pin
import pytest
from cell_operator import SPEED
from simulation import ARM

from bt_manip import build_station
from bt_manip.exceptions import MotionError
from bt_manip.runner import RunLoop
from bt_manip.scenes import Scene, SceneRobot

MINUTES = float(os.environ.get("MINUTES", "1"))  # of the robot's time
SCENE = Scene((SceneRobot(pin.SE3(np.eye(3), np.array([0.0, 0.0, 1.5]))),))  # far from the floor
RANGE = 0.8  # of the joint ranges, in which goals lie
LONGEST = 2.0  # [s] of a motion until the next one replaces it


@pytest.fixture
def busy():
    """Keep all cores busy."""
    burners = [
        subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count())
    ]
    yield
    for process in burners:
        process.kill()
        process.wait()


def move_about(station, seconds):
    """Plan motions to random goals, in the middle of others, too; return what happened."""
    arm, cell = station.arm, station.cell
    loop = RunLoop(station.resting())
    loop.open()
    limits, rng, found = arm.model.limits, np.random.default_rng(0), Counter()
    middle, half = 0.5 * (limits.lower + limits.upper), 0.5 * RANGE * (limits.upper - limits.lower)
    end, replaced = cell.time + seconds, 0.0
    while cell.time < end or arm.busy:
        resting = not arm.moving and not arm.connection.streaming
        if resting and (fault := arm.problem or arm.fault):
            found[fault] += 1
            arm.recover()
            until, arm.fault = cell.time + 2.0, ""
            while arm.problem and cell.time < until:
                loop.step()
            assert not arm.problem, "it has not recovered within 2 s"
        if cell.time < end and (not arm.busy or cell.time > replaced):
            try:
                arm.move_to_configuration(middle + rng.uniform(-half, half))
                found["motions"] += 1
                replaced = cell.time + rng.uniform(0.1, LONGEST)
            except MotionError as error:  # such as a goal at which links touch
                found["too late" if error.reason == "device" else "unplanned"] += 1
        loop.step()
    loop.close()
    return found


def measured(start_robot, *options):
    """Move about; print and return what happened, with the counts of the robot."""
    robot = start_robot(ARM, "--no-collisions", *options)
    station = build_station(
        scene=SCENE, robot="fr3", backend=f"franka={robot.host}", controller="joint_impedance",
        speed=SPEED,
    )  # fmt: skip
    began, begun = time.monotonic(), station.cell.time
    try:
        found = move_about(station, 60.0 * MINUTES)
        passed, wall = station.cell.time - begun, time.monotonic() - began
        report, counts = station.hardware.report, robot.ask("communication")
    finally:
        station.hardware.close()
    print(f"\n{passed / 60.0:.1f} minutes of the robot in {wall / 60.0:.1f}, speed {SPEED:g}:")
    print(f"  {dict(found)}, {report['late_ticks']} late ticks")
    print(f"  {counts['lost']} of {counts['cycles']} cycles without a reference; the longest gap:")
    print(f"  {counts['longest_gap']} ms of the robot, {1e3 * report['longest_gap_s']:.0f} ms here")
    print(f"  {counts['violations']} violations of communication constraints")
    return found, counts


@pytest.mark.soak
def test_motions_with_communication_constraints_go_on_to_the_end(start_robot):
    found, counts = measured(start_robot, "--constraints")
    assert found["motions"] > 10.0 * MINUTES
    assert not counts["violations"]


@pytest.mark.soak
def test_motions_while_all_cores_are_busy_go_on_to_the_end(start_robot, busy):
    found, counts = measured(start_robot)
    assert found["motions"] > 10.0 * MINUTES
    assert counts["lost"] < 0.01 * counts["cycles"]
