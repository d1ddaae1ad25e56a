"""What the tests share: faults that end with the test, the program, and a terminal."""

import numpy as np
import pytest

from bt_manip.bt import Sleep, Tree
from bt_manip_stress import FaultContext
from tests.support.drawing import (
    processes_draw_if_their_test_does as processes_draw_if_their_test_does,
)
from tests.support.program import bt_manip as bt_manip
from tests.support.program import trees as trees
from tests.support.runs import in_this_process as in_this_process
from tests.support.runs import shared_stations as shared_stations
from tests.support.runs import station_pool as station_pool
from tests.support.terminal import terminal as terminal


@pytest.fixture
def start(station):
    """Start a fault in the station; it ends after the test if it has not ended."""
    started = []

    def start(fault, seed=0, tree=None, within=station):
        tree = tree or Tree(Sleep("rest", msec=1000), clock=station.clock)
        context = FaultContext(within, tree, tree.nodes[-1], np.random.default_rng(seed))
        fault.start(context)
        started.append(fault)
        return fault

    yield start
    for fault in started:
        fault.end()
