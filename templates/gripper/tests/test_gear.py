"""An arm with the gripper fulfils the contract of robots, and picks."""

import pytest
from bt_manip import build_station as build
from bt_manip.behaviours import Grasp, Hover, Lift, OpenGripper, Reach
from bt_manip.bt import Sequence
from bt_manip_contracts import contracts_of

test_contracts = contracts_of("gear")


@pytest.fixture(scope="session")
def build_station(parts):
    """Build the station with this arm."""
    return lambda: build(parts, robot="gear")


def test_it_picks_the_cube(trial, cell):
    steps = [Hover(object="cube", height=0.15), Reach(object="cube")]
    steps += [Grasp(object="cube", force=20.0), Lift(height=0.15)]
    before = cell.pose("cube").translation[2]
    trial(Sequence(*steps)).tick_until("SUCCESS", timeout=15.0)
    assert cell.pose("cube").translation[2] > before + 0.1


def test_it_releases_the_cube(trial, station):
    steps = [Hover(object="cube", height=0.15), Reach(object="cube"), Grasp(object="cube")]
    trial(Sequence(*steps, OpenGripper())).tick_until("SUCCESS", timeout=15.0)
    assert station.gripper.is_open and station.gripper.held == ()
