"""The station of these tests: the table with the tray, and blocks on it."""

import pytest

from bt_manip import build_station as build
from bt_manip import spatial
from bt_manip.behaviours import Grasp, Hover, Lift, Reach
from bt_manip.testing import AT_REST, Situations, play
from bt_manip_blocks import ColouredBlock
from bt_manip_blocks.scene import table_and_tray

SURFACE = 1.015  # [m]


@pytest.fixture(scope="session")
def build_station(parts):
    return lambda: build(parts, scene=table_and_tray())


@pytest.fixture(scope="session")
def situations(build_station):
    situations = Situations(build_station)
    situations.add(AT_REST, lambda station: station.cell.step(100), after=None)
    situations.add("one block", put_one_block)
    situations.add("two blocks", put_two_blocks)
    situations.add("holding a block", pick_red, after="two blocks")
    return situations


def put_one_block(station):
    """A red block."""
    station.cell.add(ColouredBlock(colour="red"), spatial.pose((0.35, -0.1, SURFACE + 0.02)))
    station.cell.step(100)


def put_two_blocks(station):
    """A red block beside a green one, 45 mm from centre to centre."""
    with station.cell.editing():
        for colour, y in (("red", -0.1), ("green", -0.145)):
            station.cell.add(ColouredBlock(colour=colour), spatial.pose((0.35, y, SURFACE + 0.02)))
    station.cell.step(100)


def pick_red(station):
    play(
        station,
        Hover(object="red", height=0.15), Reach(object="red"), Grasp(object="red", force=30.0),
        Lift(height=0.15),
    )  # fmt: skip
