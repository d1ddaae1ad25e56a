"""What cannot be added is one error, and the cell is as it was."""

import re

import numpy as np
import pytest
import trimesh

from bt_manip.cell import Cell, CellError, Cube, Region, Table
from bt_manip.cell.objects import Catalogue, ModelObject
from bt_manip.exceptions import BtManipError
from bt_manip.spatial import pose


@pytest.fixture
def holed(tmp_path):
    mesh = trimesh.creation.box((0.1, 0.1, 0.1))
    mesh.update_faces([True] * 10 + [False] * 2)
    mesh.export(tmp_path / "holed.stl")
    return tmp_path / "holed.stl"


def add(cell, entity, *place, **options):
    cell.add(entity, pose(place or (0.0, 0.0, 2.0)), **options)


@pytest.mark.parametrize(
    ("attempt", "message"),
    [
        (lambda cell, **_: add(cell, Cube(), name="cube"), "already a 'cube' .* 'cube_1' is free"),
        (lambda cell, **_: add(cell, Cube(), 0.3, 0.0, 1.0), r"40\.0 mm inside 'table'"),
        (lambda cell, **_: add(cell, Cube(mass=0.0)), "mass must be a number above 0 .*, got 0"),
        (
            lambda cell, **_: add(cell, Cube(mass=-1.0)),
            "mass must be a number above 0 and at most 1e.10 .kg., got -1",
        ),
        (lambda cell, holed, **_: add(cell, ModelObject(str(holed))), "holed.stl.*not watertight"),
        (lambda cell, **_: add(cell, ModelObject("no/such.xml")), "no/such.xml"),
        (lambda cell, parts, **_: add(cell, Catalogue(parts.objects).create("fule:a/b")), "fule"),
        (lambda cell, parts, **_: add(cell, Catalogue(parts.objects).create("cub")), "mean 'cube'"),
    ],
)
def test_it_is_refused_and_the_cell_goes_on_as_if_nothing_had_been_asked(
    parts, holed, attempt, message
):
    cell, undisturbed = Cell(), Cell()
    for one in (cell, undisturbed):
        with one.editing():
            one.add(Table())
            one.add(Cube(), pose((0.3, 0.3, 1.2), (0.9, 0.1, 0.2, 0.3)))
        one.step(50)
    generation, entities = cell.generation, dict(cell.entities)
    with pytest.raises(BtManipError, match=message) as raised:
        attempt(cell=cell, parts=parts, holed=holed)
    assert "\n" not in str(raised.value)
    assert (cell.generation, dict(cell.entities)) == (generation, entities)
    assert cell.state_bytes() == undisturbed.state_bytes()
    for one in (cell, undisturbed):
        one.step(100)
    assert cell.state_bytes() == undisturbed.state_bytes()


def test_a_name_that_is_taken_is_refused_when_a_place_is_drawn_too():
    cell = Cell()
    cell.add(Cube(), pose((0.0, 0.0, 1.0)))
    region = Region(x=(1.0, 2.0), y=(0.0, 1.0), z=(1.0, 1.0))
    with pytest.raises(CellError, match=re.escape("there is already a 'cube'")):
        cell.place(Cube(), region, np.random.default_rng(0), name="cube")
