"""The built-in parts, and a station with two robots and a cube between them."""

import pytest

from bt_manip import spatial
from bt_manip.bt import Tree
from bt_manip.plugins import load_plugins
from bt_manip.registry import Parts
from bt_manip.runner import Fixture, Scene, build_station, two_arms
from bt_manip.testing.trial import Trial


@pytest.fixture(scope="session")
def parts() -> Parts:
    return load_plugins(entry_points=()).parts


@pytest.fixture(scope="module")
def two_robots(parts):
    cube = Fixture("cube", "cube", spatial.pose((0.0, 0.0, 1.04)), free=True)
    scene = two_arms()
    station = build_station(parts, scene=Scene(scene.robots, (*scene.fixtures, cube)))
    return station, station.get_state()


@pytest.fixture
def station(two_robots):
    station, start = two_robots
    station.set_state(start)
    return station


@pytest.fixture
def left(station):
    return station.robots["left"]


@pytest.fixture
def right(station):
    return station.robots["right"]


def set_up(station, root):
    return Trial(station, Tree(root, clock=station.clock))
