"""One more situation, for behaviours that set things down on others."""

import pytest

from bt_manip import spatial

BESIDE_ANOTHER = "holding a cube, another on the table"


@pytest.fixture(scope="session")
def situations(situations):
    situations.add(BESIDE_ANOTHER, put_another, after="holding a cube over the table")
    return situations


def put_another(station):
    cube = station.models.create("cube")
    station.cell.add(cube, spatial.pose((0.35, -0.15, 1.04)), name="other")
    station.cell.step(100)
