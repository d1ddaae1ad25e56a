"""The station of these tests: the box on the table, and cans."""

import pytest

from bt_manip import build_station as build
from bt_manip.spatial import pose
from bt_manip.testing import AT_REST, Situations

SURFACE = 1.015  # [m]


@pytest.fixture(scope="session")
def build_station(parts):
    return lambda: build(parts, scene="cans_into_box")


@pytest.fixture(scope="session")
def situations(build_station):
    situations = Situations(build_station)
    situations.add(AT_REST, lambda station: station.cell.step(100), after=None)
    situations.add("two cans", put_two_cans)
    situations.add("a can in the box", put_one_into_the_box, after="two cans")
    return situations


def put_two_cans(station):
    """A red can and a green one on the table."""
    with station.cell.editing():
        for name, y in (("red_can", -0.1), ("green_can", 0.1)):
            station.cell.add(station.models.create(name), pose((0.3, y, SURFACE)), name=name)
    station.cell.step(100)


def put_one_into_the_box(station):
    """The red can stands in the box."""
    T_wb = station.cell.pose("box")
    station.cell.move("red_can", pose(T_wb.translation + (0.0, 0.1, 0.008)))
    station.cell.step(200)
