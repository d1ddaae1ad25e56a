"""What is placed rests in the container; how high it is gripped does not matter."""

import pytest

from bt_manip.cell import Basket, Cell
from bt_manip.cell.objects import Bottle
from bt_manip.recording.placement import PlacementCheck
from bt_manip.spatial import pose


@pytest.fixture
def cell():
    cell = Cell()
    cell.add(Basket(), pose((0.0, 0.0, 0.0)))
    return cell


def test_a_bottle_that_is_gripped_over_the_rim_is_placed_when_it_stands_inside(cell):
    bottle = Bottle()
    cell.add(bottle, pose((0.0, 0.0, bottle.rest_height + 0.02)))
    cell.step(1500)
    grip = cell.pose("bottle").act(bottle.centre_offset)
    geoms = [g for g in range(cell.model.ngeom) if cell.model.geom(g).name.startswith("basket/")]
    rim = max(cell.data.geom_xpos[g, 2] for g in geoms)
    assert grip[2] > rim
    assert PlacementCheck(cell).placed("bottle")


def test_a_bottle_beside_the_container_is_not_placed(cell):
    bottle = Bottle()
    cell.add(bottle, pose((1.0, 0.0, bottle.rest_height)))
    cell.step(500)
    assert not PlacementCheck(cell).placed("bottle")
