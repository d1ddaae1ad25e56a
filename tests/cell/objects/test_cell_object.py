"""Objects declare what they are; undeclared attributes have documented defaults."""

import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip.cell import Cell, CellError, Cube, Table, as_object, bottom_of
from bt_manip.cell.objects import Can
from bt_manip.spatial import pose


class Brick(composer.Entity):
    """An object of a plugin, which inherits from composer's Entity only."""

    kind, free, rest_height = "brick", True, 0.03

    def _build(self) -> None:
        self._root = mjcf.RootElement(model="brick")
        self._root.worldbody.add("geom", type="box", size=(0.03, 0.03, 0.03))

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        return self._root


def test_a_foreign_entity_has_its_own_attributes_and_defaults_for_the_others():
    brick = as_object(Brick())
    assert (brick.kind, brick.free, brick.rest_height) == ("brick", True, 0.03)
    assert (brick.category, brick.mass, brick.surface_height) == ("", 0.0, None)
    assert dict(brick.parameters) == {} and not np.any(brick.centre_offset)
    assert brick.get_state() is None


def test_a_mistake_inside_a_property_is_not_taken_for_an_undeclared_attribute():
    class Shelf(Brick):
        @property
        def surface_height(self):
            return self.hieght

    cell = Cell()
    cell.add(Shelf(), pose((0.0, 0.0, 0.03)))
    with pytest.raises(AttributeError, match="'Shelf' object has no attribute 'hieght'"):
        cell.surface_height("brick")


def test_a_class_can_be_read_and_an_object_that_inherits_the_defaults_is_read_as_it_is():
    cube = Cube()
    assert as_object(cube) is cube
    assert as_object(cube).rest_height == pytest.approx(0.5 * cube.size)
    assert as_object(Brick).kind == "brick"
    assert as_object(lambda: None).category == ""


def test_the_bottom_is_under_the_middle_at_the_rest_height():
    assert bottom_of(Brick()).translation.tolist() == [0.0, 0.0, -0.03]
    assert bottom_of(Can()).translation.tolist() == [0.0, 0.0, 0.0]


def test_the_surface_of_an_entity_is_found_in_the_world():
    cell = Cell()
    table = Table()
    cell.add(table, pose((0.0, 0.0, 0.1)))
    cell.add(Brick(), pose((2.0, 0.0, 0.03)))
    assert cell.surface_height("table") == pytest.approx(0.1 + table.surface_height)
    with pytest.raises(CellError, match="'brick' has no surface to place objects on"):
        cell.surface_height("brick")
