"""Objects are what their parameters say."""

import numpy as np
import pytest

from bt_manip.cell import Basket, Cell, CellError, Cube, Table
from bt_manip.spatial import pose


def test_mass_inertia_friction_and_colour_reach_the_compiled_model():
    cell = Cell()
    cell.add(Cube(size=0.1, mass=0.3, friction=0.3, colour=(1, 0, 0)), pose((0, 0, 1)))
    body = cell.model.body("cube/cube")
    assert body.mass[0] == pytest.approx(0.3)
    np.testing.assert_allclose(body.inertia, 0.3 * 0.1**2 / 6)  # of a solid one
    np.testing.assert_allclose(cell.model.geom("cube/box").friction[0], 0.3)
    np.testing.assert_allclose(cell.model.geom("cube/wood").rgba, (1, 0, 0, 1))


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
