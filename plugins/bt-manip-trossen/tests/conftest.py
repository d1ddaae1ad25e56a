"""A simulated arm in a process of its own."""

import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(__file__))  # for `widowx`

from widowx import SimulatedWidowX  # noqa: E402


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    """An arm alone, which is left ready."""
    pytest.importorskip("trossen_arm")
    robot = SimulatedWidowX(tmp_path_factory.mktemp("robot") / "log")
    yield robot
    robot.end()
