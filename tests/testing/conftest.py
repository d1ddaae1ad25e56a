"""More situations: for behaviours that set things down on others, or move back."""

import pytest

from bt_manip import spatial
from bt_manip.behaviours import MoveLinear
from bt_manip.testing.situations import play

AFTER_A_MOTION = "after a motion"
BESIDE_ANOTHER = "holding a cube, another on the table"


@pytest.fixture
def situations(situations):
    situations.add(BESIDE_ANOTHER, put_another, after="holding a cube over the table")
    situations.add(AFTER_A_MOTION, move)
    return situations


def move(station):
    play(station, MoveLinear(pose="0.4;-0.05;1.4;0;1;0;0"))


def put_another(station):
    cube = station.models.create("cube")
    station.cell.add(cube, spatial.pose((0.35, -0.15, 1.04)), name="other")
    station.cell.step(100)
