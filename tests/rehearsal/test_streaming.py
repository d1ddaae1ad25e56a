"""Random motions reach the robot through the connection, and its limits accept them."""

import numpy as np
import pytest
from real_cell import CUBES
from simulation import ARM

from bt_manip.robots import DeviceError, Robot, compile_alone, read_description
from bt_manip.robots.connection import ArmConnection, LateError
from tests.measuring.random_commands import RandomCommands

MOTIONS = 20 if CUBES >= 20 else 2
ATTEMPTS = 5  # where the machine is too busy to simulate without losing cycles
LATENCY = 30  # setpoints


@pytest.fixture(scope="module")
def fr3(models):
    description_files = pytest.importorskip("bt_manip_menagerie").description_files
    return read_description(next(path for path in description_files() if path.stem == "fr3"))


@pytest.fixture(scope="module")
def robot(start_robot):
    """A robot whose links pass through each other, as motions of an arm alone let them."""
    return start_robot(ARM, "--patient", "--no-collisions")


@pytest.fixture(scope="module")
def connection(robot, fr3):
    alone = Robot(fr3)
    compile_alone(alone)
    connection = ArmConnection("bt_manip_franka.device:FrankaArm", robot.host, alone.limits)
    yield connection
    connection.close()


def take(connection, setpoints):
    connection.wait(setpoints)
    for _ in range(setpoints):
        reading = connection.take()
    return reading


def stream(connection, setpoints, rng):
    """Send a motion, and again and again its rest from a later setpoint on; return a reading."""
    begun, late = None, 0
    while not connection.problem and (
        begun is None or connection.setpoint + LATENCY < begun + len(setpoints) - 1
    ):
        take(connection, 1 + connection.lag)
        first = connection.setpoint + LATENCY
        try:
            connection.send(LATENCY, setpoints if begun is None else setpoints[first - begun :])
        except LateError:
            late += 1
            assert late < 20
            continue
        except DeviceError:  # a reflex, which `connection.problem` names
            break
        begun = first if begun is None else begun
        take(connection, int(rng.integers(100, 1000)))
    return take(connection, LATENCY + 300)


def test_random_motions_with_stops_and_blends_are_accepted(robot, fr3, connection):
    commands, rng, again = RandomCommands(fr3), np.random.default_rng(0), 0
    for seed in range(MOTIONS):
        motion = commands.motion(seed)
        for _ in range(ATTEMPTS):
            lost = robot.ask("communication")["lost"]
            robot.ask("move_by_hand", q=motion.q[0].tolist())
            take(connection, 50 + connection.lag)
            reading = stream(connection, motion.q, rng)
            if not connection.problem:
                break
            # The controller extrapolates lost cycles, beyond limits that the motion almost uses.
            assert robot.ask("communication")["lost"] > lost, f"motion {seed}: {connection.problem}"
            again += 1
            connection.recover()
            take(connection, 500)
        assert not connection.problem
        np.testing.assert_allclose(reading.q, motion.q[-1], atol=5e-3)  # friction
    found = robot.ask("communication")
    print(f"{MOTIONS} motions, {again} more after lost cycles; {found}", end=" ")
    print(f"longest wall time of a cycle {connection.longest_gap:.4f} s")
