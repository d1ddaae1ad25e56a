"""Random motions reach the robot through the link, and its limits accept them."""

import os

import numpy as np
import pytest
from simulation import MENAGERIE

from bt_manip.robots import DeviceError, Robot, compile_alone, read_description
from bt_manip.robots.connection import ArmConnection, LateError
from tests.measuring.random_commands import RandomCommands

CUBES = int(os.environ.get("CUBES", "3"))
ARM = MENAGERIE / "franka_fr3" / "fr3.xml"
MOTIONS = 20 if CUBES >= 20 else 4
ATTEMPTS = 5  # where the machine is too busy to simulate without losing cycles
LEAD = 30  # rows


@pytest.fixture(scope="module")
def fr3(models):
    description_files = pytest.importorskip("bt_manip_menagerie").description_files
    return read_description(next(path for path in description_files() if path.stem == "fr3"))


@pytest.fixture(scope="module")
def robot(start_robot):
    """A robot whose links pass through each other, as motions of an arm alone let them."""
    return start_robot(ARM, "--patient", "--no-collisions")


@pytest.fixture(scope="module")
def link(robot, fr3):
    alone = Robot(fr3)
    compile_alone(alone)
    link = ArmConnection("bt_manip_franka.device:FrankaArm", robot.host, alone.limits)
    yield link
    link.close()


def take(link, rows):
    link.wait(rows)
    for _ in range(rows):
        reading = link.take()
    return reading


def stream(link, rows, rng):
    """Send rows from rest to rest, and from a later one on again and again; return a reading."""
    begun, late = None, 0
    while not link.problem and (begun is None or link.rows + LEAD < begun + len(rows) - 1):
        take(link, 1 + link.behind)
        first = link.rows + LEAD
        try:
            link.send(LEAD, rows if begun is None else rows[first - begun :])
        except LateError:
            late += 1
            assert late < 20
            continue
        except DeviceError:  # a reflex, which `link.problem` names
            break
        begun = first if begun is None else begun
        take(link, int(rng.integers(100, 1000)))
    return take(link, LEAD + 300)


def test_random_motions_with_stops_and_blends_are_accepted(robot, fr3, link):
    commands, rng, again = RandomCommands(fr3), np.random.default_rng(0), 0
    for seed in range(MOTIONS):
        motion = commands.motion(seed)
        for _ in range(ATTEMPTS):
            lost = robot.ask("communication")["lost"]
            robot.ask("move_by_hand", q=motion.q[0].tolist())
            take(link, 50 + link.behind)
            reading = stream(link, motion.q, rng)
            if not link.problem:
                break
            # The controller extrapolates lost cycles, beyond limits that the motion almost uses.
            assert robot.ask("communication")["lost"] > lost, f"motion {seed}: {link.problem}"
            again += 1
            link.recover()
            take(link, 500)
        assert not link.problem
        np.testing.assert_allclose(reading.q, motion.q[-1], atol=5e-3)  # friction
    found = robot.ask("communication")
    print(f"{MOTIONS} motions, {again} more after lost cycles; {found}", end=" ")
    print(f"longest wall time of a cycle {link.longest_gap:.4f} s")
