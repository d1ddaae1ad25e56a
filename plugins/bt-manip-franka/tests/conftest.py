"""A simulated robot in a process of its own."""

import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(__file__))  # for `simulation`

from simulation import MENAGERIE, SimulatedRobot  # noqa: E402


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    """A robot alone, which is left ready."""
    pytest.importorskip("pylibfranka")
    log = tmp_path_factory.mktemp("robot") / "log"
    robot = SimulatedRobot(MENAGERIE / "franka_fr3" / "fr3.xml", log=log)
    yield robot
    robot.end()
    print(log.read_text()[-3000:], file=sys.stderr)
