"""What the tests share: drawing, runs in stations of their own, and the program."""

import pytest

from tests.support.drawing import opengl as opengl
from tests.support.drawing import (
    processes_draw_if_their_test_does as processes_draw_if_their_test_does,
)
from tests.support.file_size import file_size_limit as file_size_limit
from tests.support.file_size import pytest_runtest_call as pytest_runtest_call
from tests.support.program import bt_manip as bt_manip
from tests.support.program import task as task
from tests.support.program import trees as trees
from tests.support.runs import make_run as make_run
from tests.support.runs import picked as picked
from tests.support.runs import shared_stations as shared_stations
from tests.support.runs import station_pool as station_pool


@pytest.fixture(autouse=True)
def tests_share_stations(shared_stations) -> None:
    """Let runs have the stations of the tests before."""
