import pytest

from bt_manip.cell import Cell, Cube, Table
from bt_manip.spatial import pose

SURFACE = 1.015  # [m]


@pytest.fixture(scope="module")
def cell():
    """A light cube on a heavy one on the table."""
    cell = Cell()
    with cell.editing():
        cell.add(Table())
        cell.add(Cube(mass=2.0), pose((0.1, 0.2, SURFACE + 0.025)), name="heavy")
        cell.add(Cube(mass=0.5), pose((0.1, 0.2, SURFACE + 0.075)), name="light")
    cell.step(500)
    return cell
