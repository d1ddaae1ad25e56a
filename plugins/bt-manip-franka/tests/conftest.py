"""A simulated robot in a process of its own."""

import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(__file__))  # for `simulation`

from simulation import start_franka  # noqa: E402


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    """A robot alone, which is left ready."""
    pytest.importorskip("pylibfranka")
    robot = start_franka(tmp_path_factory.mktemp("robot") / "log")
    yield robot
    robot.end()
