"""Objects are what their parameters say."""

import numpy as np
import pytest

from bt_manip.cell import Basket, Cell, CellError, Cube, Table
from bt_manip.spatial import pose


def test_a_cube_has_the_mass_and_inertia_of_a_solid_one():
    cell = Cell()
    cell.add(Cube(size=0.1, mass=0.3), pose((0, 0, 1)))
    body = cell.model.body("cube/cube")
    assert body.mass[0] == pytest.approx(0.3)
    np.testing.assert_allclose(body.inertia, 0.3 * 0.1**2 / 6)


def test_the_default_cube_is_the_reference_tasks():
    cube = Cube()
    assert cube.size == pytest.approx(0.05)
    assert cube.mass == pytest.approx(0.0565)
    assert cube.rest_height == pytest.approx(0.025)


def test_friction_and_colour_reach_the_compiled_model():
    cell = Cell()
    cell.add(Cube(friction=0.3, colour=(1, 0, 0)), pose((0, 0, 1)))
    np.testing.assert_allclose(cell.model.geom("cube/box").friction[0], 0.3)
    np.testing.assert_allclose(cell.model.geom("cube/wood").rgba, (1, 0, 0, 1))


def test_the_tables_surface_carries_at_its_height():
    cell = Cell()
    table = Table()
    cell.add(table)
    cell.add(Cube(), pose((0, 0, table.surface_height + 0.025 + 0.01)))
    cell.step(500)
    assert cell.pose("cube").translation[2] == pytest.approx(1.015 + 0.025, abs=1e-4)


def test_the_basket_is_open_and_catches():
    cell = Cell()
    cell.add(Basket(), pose((0, 0, 0.5)))
    cell.add(Cube(), pose((0, 0, 0.8)))
    cell.step(800)
    assert cell.contacts.pairs() == [("basket", "cube")]
    assert 0.5 < cell.pose("cube").translation[2] < 0.55


def test_a_free_basket_has_the_mass_asked_for():
    cell = Cell()
    cell.add(Basket(mass=1.5), pose((0, 0, 0.0)), free=True)
    cell.step(300)
    weight = cell.contacts.between("world", "basket").normal
    assert weight == pytest.approx(1.5 * 9.81, rel=1e-3)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"mass": 0.0}, "mass must be a number above 0 and at most 1e.10 .kg., got 0.0"),
        ({"mass": -1.0}, "mass must be"),
        ({"size": float("nan")}, "size must be"),
        ({"friction": -0.5}, "friction must be"),
        ({"colour": (2, 0, 0)}, "colour must be 3 or 4 numbers"),
    ],
)
def test_impossible_parameters_are_refused(parameters, message):
    with pytest.raises(CellError, match=message):
        Cube(**parameters)


@pytest.mark.parametrize("kind", [Cube, Table, Basket])
def test_an_object_can_be_made_again_from_its_parameters(kind):
    made = kind(friction=0.4)
    again = kind(**made.parameters)
    assert again.mjcf_model.to_xml_string() == made.mjcf_model.to_xml_string()
    assert made.kind == kind.__name__.lower()
