"""Contacts and their forces, against weights computed by hand."""

import numpy as np
import pytest

from bt_manip.cell import Cell, CellError, Cube
from bt_manip.spatial import pose

G = 9.81


def test_pairs_are_named_by_entity_and_come_once(cell):
    assert cell.contacts.pairs() == [("heavy", "light"), ("heavy", "table")]
    assert cell.contacts.touching("heavy")
    assert cell.contacts.touching("light", "heavy")
    assert not cell.contacts.touching("light", "table")
    assert cell.contacts.partners("heavy") == ["light", "table"]


def test_the_normal_force_is_the_weight_above(cell):
    force = cell.contacts.between("table", "heavy")
    assert force.normal == pytest.approx(2.5 * G, rel=1e-3)
    np.testing.assert_allclose(force.force, (0, 0, 2.5 * G), atol=0.03)
    assert cell.contacts.between("heavy", "table").force[2] == pytest.approx(-2.5 * G, rel=1e-3)
    assert cell.contacts.between("light", "table").normal == 0


def slope(mu, steps):
    """A cube of 1 kg on the floor, gravity turned by 20 degrees."""
    angle = np.radians(20)
    cell = Cell()
    cell.arena.mjcf_model.option.gravity = (G * np.sin(angle), 0, -G * np.cos(angle))
    cell.arena.mjcf_model.find("geom", "floor").friction = (1e-5, 0.005, 0.0001)
    cell.add(Cube(mass=1.0, friction=mu), pose((0, 0, 0.025)))
    cell.step(steps)
    return cell, angle


def test_friction_holds_a_cube_on_a_slope_inside_its_cone():
    cell, angle = slope(0.6, 300)
    force = cell.contacts.between("world", "cube")
    assert force.normal == pytest.approx(G * np.cos(angle), rel=1e-3)
    assert force.friction == pytest.approx(G * np.sin(angle), rel=1e-3)
    np.testing.assert_allclose(force.force, (-G * np.sin(angle), 0, force.normal), atol=1e-3)
    assert np.linalg.norm(cell.velocity("cube")) < 1e-3


def test_nothing_touches_in_the_air():
    cell = Cell()
    cell.add(Cube(), pose((0, 0, 3)))
    cell.step(3)
    assert cell.contacts.pairs() == []
    assert not cell.contacts.touching("cube")
    np.testing.assert_array_equal(cell.contacts.wrench("cube").force, 0)


def test_an_unknown_body_offers_the_nearest(cell):
    with pytest.raises(CellError, match="did you mean 'heavy'"):
        cell.contacts.wrench("heavi")


def test_the_wrench_of_a_resting_object_is_its_weight(cell):
    wrench = cell.contacts.wrench("light")
    np.testing.assert_allclose(wrench.force, (0, 0, 0.5 * G), rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(wrench.torque, 0, atol=1e-3)
    both_sides = cell.contacts.wrench("heavy")  # table up, light cube down
    np.testing.assert_allclose(both_sides.force, (0, 0, 2.0 * G), rtol=1e-3, atol=1e-3)
