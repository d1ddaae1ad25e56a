"""What the tests share: drawing, the program, stations, and which contracts are left out."""

import os

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
