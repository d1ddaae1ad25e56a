"""What the tests share: drawing, the program, stations, and which contracts are left out."""

import os
from pathlib import Path

import pytest

from tests.support.drawing import opengl as opengl
from tests.support.drawing import (
    processes_draw_if_their_test_does as processes_draw_if_their_test_does,
)
from tests.support.program import bt_manip as bt_manip
from tests.support.runs import in_this_process as in_this_process
from tests.support.runs import shared_stations as shared_stations
from tests.support.runs import station_pool as station_pool


@pytest.fixture(autouse=True)
def tests_share_stations(shared_stations) -> None:
    """Let episodes have the stations of the tests before."""


SMALL_TREES = """
import os

from bt_manip.behaviours import Hover, ObjectExists, SpawnObject
from bt_manip.bt import Action, Sequence, Sleep, Tree


def aimless(goal="never", there="table"):
    steps = SpawnObject(object="{cube}"), Hover(object="{cube}", height=0.3)
    then = ObjectExists("is there", object=there), Sleep(msec=200)
    return Tree(Sequence("task", *steps, *then), goal=ObjectExists(object=goal))


def tree():
    return aimless("{cube}")


class Leave(Action):
    def update(self):
        os._exit(0)


def leaving():
    return Tree(Sequence("task", tree().root, Leave()))


def gone():
    return Tree(Leave())
"""


@pytest.fixture(scope="session")
def small_trees(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a file of trees that hover over a cube, and of trees that end their process."""
    path = tmp_path_factory.mktemp("trees") / "small.py"
    path.write_text(SMALL_TREES)
    return path


@pytest.fixture
def lerobot() -> str:
    """Give the Python of an environment with LeRobot, or skip the test."""
    python = os.environ.get("LEROBOT_PYTHON")
    if python is None:
        pytest.skip("LEROBOT_PYTHON is not set: the Python of an environment with lerobot")
    return python


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave the contracts that take seconds to soak, but for one kind of actions."""
    for item in items:
        kind, _, check = item.name.partition("[")[2].partition(": ")
        if "cartesian_deltas" != kind and check.startswith(("goes on from its", "has the same")):
            item.add_marker("soak")
