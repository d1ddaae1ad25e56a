"""A simulated arm in a process of its own."""

import os
import sys

import pytest

sys.path.insert(0, os.path.dirname(__file__))  # for `widowx`

from widowx import start_widowx  # noqa: E402


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    """An arm alone, which is left ready."""
    pytest.importorskip("trossen_arm")
    robot = start_widowx(tmp_path_factory.mktemp("robot") / "log")
    yield robot
    robot.end()
