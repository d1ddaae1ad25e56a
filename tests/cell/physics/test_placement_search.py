"""Things are put where there is room, or not at all."""

import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip.cell import Basket, Cell, CellError, Cube, OverlapError, Region, Table
from bt_manip.cell.objects import Wall
from bt_manip.spatial import pose

SURFACE = 1.015
HALF = 0.025
ON_TABLE = Region(x=(0.2, 0.4), y=(-0.3, 0.3), z=(SURFACE + HALF, SURFACE + HALF))


@pytest.fixture
def cell():
    return with_table()


def with_table():
    cell = Cell()
    cell.add(Table())
    cell.step(2)
    return cell


def outcome(cell):
    return cell.generation, list(cell.entities), cell.state_bytes()


@pytest.mark.parametrize("free", [True, False])
def test_a_pose_inside_another_object_is_refused_and_nothing_changes(cell, free):
    cell.add(Cube(), pose((0.3, 0, SURFACE + HALF)))
    before = outcome(cell)
    with pytest.raises(OverlapError, match="'cube_1'.* 10.0 mm inside 'table'.* up to 2 mm"):
        cell.add(Cube(), pose((0, 0, SURFACE + HALF - 0.01)), free=free)
    with pytest.raises(OverlapError, match="20.0 mm inside 'cube'"):
        cell.add(Cube(), pose((0.33, 0, SURFACE + HALF)), free=free)
    assert outcome(cell) == before
    cell.add(Cube(), pose((0.35, 0, SURFACE + HALF)), free=free)  # face to face


def test_an_overlap_can_be_asked_for_and_what_nothing_touches_may_stand_anywhere(cell):
    cell.add(Cube(), pose((0, 0, SURFACE + HALF - 0.01)), overlap=np.inf)
    ghost = mjcf.RootElement(model="ghost")
    ghost.worldbody.add("geom", size=(1.0,), mass=1, contype=0, conaffinity=0)
    cell.add(composer.ModelWrapperEntity(ghost), pose((0.5, 0, SURFACE)))
    cell.add(Cube(), pose((0.5, 0, SURFACE + HALF)))


def test_a_name_that_is_taken_is_refused_at_a_given_place_and_at_a_drawn_one(cell):
    cell.add(Cube(), pose((0, 0, 2)))
    before = outcome(cell)
    with pytest.raises(CellError, match="already a 'cube' .* 'cube_1' is free"):
        cell.add(Cube(), pose((0, 0, 3)), name="cube")
    with pytest.raises(CellError, match="there is already a 'cube'"):
        cell.place(Cube(), ON_TABLE, np.random.default_rng(0), name="cube")
    assert outcome(cell) == before


def test_an_edit_checks_what_came_together(cell):
    before = outcome(cell)
    with pytest.raises(OverlapError), cell.editing():
        cell.add(Cube(), pose((0, 0, SURFACE + HALF)))
        cell.add(Cube(), pose((0.01, 0, SURFACE + HALF)))
    assert outcome(cell) == before


def test_things_are_placed_clear_of_each_other_by_the_generator_alone(cell):
    def placed(cell):
        rng = np.random.default_rng(1)
        with cell.editing():
            names = [cell.place(Cube(), ON_TABLE, rng) for _ in range(5)]
        return names + [cell.place(Cube(), ON_TABLE, rng) for _ in range(2)]

    names, other = placed(cell), with_table()
    assert all(partner == "table" for name in names for partner in cell.contacts.partners(name))
    centres = np.array([cell.pose(name).translation for name in names])
    assert (np.abs(centres[:, :2] - (0.3, 0.0)) <= (0.1, 0.3)).all()
    assert [other.pose(name) for name in placed(other)] == [cell.pose(name) for name in names]


def test_where_nothing_is_free_the_reason_is_told_and_the_cell_is_unchanged(cell):
    cell.add(Cube(size=0.2), pose((0.3, 0, SURFACE + 0.1)), name="block")
    cell.step(300)
    before = outcome(cell)
    taken = Region(x=(0.28, 0.32), y=(-0.02, 0.02), z=(SURFACE + HALF, SURFACE + HALF))
    message = "'cube' cannot be placed: no free pose in 20 attempts; .* inside 'block'"
    cube = Cube()
    with pytest.raises(CellError, match=message):
        cell.place(cube, taken, np.random.default_rng(0), attempts=20)
    assert outcome(cell) == before
    assert cell.place(cube, ON_TABLE, np.random.default_rng(0)) == "cube"


def test_what_is_dropped_comes_to_rest_on_what_is_there(cell):
    cell.add(Cube(size=0.1), pose((0.3, 0, SURFACE + 0.05)), name="block")
    cell.step(300)
    time = cell.time
    over = Region(x=(0.29, 0.31), y=(-0.01, 0.01), z=(1.3, 1.3))
    name = cell.place(Cube(), over, np.random.default_rng(0), drop=True)
    assert cell.time == time
    cell.step(100)
    assert cell.contacts.partners(name) == ["block"]
    assert cell.pose(name).translation[2] == pytest.approx(SURFACE + 0.1 + HALF, abs=1e-3)
    assert np.linalg.norm(cell.velocity(name)) < 1e-2


def test_what_is_fixed_is_placed_turned_where_it_fits_so(cell):
    def place(yaw):
        region = Region((0.3, 0.3), (0.0, 0.0), (SURFACE, SURFACE), yaw=(yaw, yaw))
        with cell.editing():
            return cell.place(Wall(), region, np.random.default_rng(0), attempts=1)

    for y in (-0.1, 0.1):  # the wall is 0.04 x 0.4 m
        cell.add(Cube(), pose((0.3, y, SURFACE + HALF)), free=False)
    with pytest.raises(CellError, match="'wall' cannot be placed"):
        place(0.1)
    assert cell.pose(place(np.pi / 2)).isApprox(
        pose((0.3, 0.0, SURFACE), (0.5**0.5, 0.0, 0.0, 0.5**0.5))
    )


@pytest.mark.parametrize(("depth", "free"), [(0.08e-3, True), (0.12e-3, False)])
def test_a_place_is_free_with_up_to_a_tenth_of_a_millimetre_of_overlap(depth, free):
    cell, height = Cell(), HALF - depth
    region = Region((0.1, 0.1), (0.2, 0.2), (height, height))
    if free:
        assert cell.place(Cube(), region, np.random.default_rng(0)) == "cube"
    else:
        with pytest.raises(CellError, match="in 3 attempts; .* 0.1 mm inside 'world'"):
            cell.place(Cube(), region, np.random.default_rng(0), attempts=3)


@pytest.mark.parametrize(
    ("gravity", "height", "rests"),
    [(0.095, 0.5, 0.5), (0.105, 0.5, None), (1.0, 0.9, HALF), (1.0, 2.1, None)],
)
def test_what_is_slower_than_5_mm_s_for_50_ms_of_2_s_is_at_rest(gravity, height, rests):
    """After 50 ms in a gravity of 0.1 m/s^2 it falls at 5 mm/s, after 2 s in one of 1 m/s^2 2 m."""
    cell = Cell()
    cell.arena.mjcf_model.option.gravity = (0.0, 0.0, -gravity)
    region = Region((0.1, 0.1), (0.2, 0.2), (height, height))
    if rests is None:
        with pytest.raises(CellError, match="it does not come to rest"):
            cell.place(Cube(), region, np.random.default_rng(0), attempts=1, drop=True)
    else:
        name = cell.place(Cube(), region, np.random.default_rng(0), attempts=1, drop=True)
        assert cell.pose(name).translation == pytest.approx([0.1, 0.2, rests], abs=1e-3)


def test_what_rolls_out_of_the_region_is_not_placed(cell):
    cell.add(Basket(), pose((0.3, 0, SURFACE)))
    rim = Region(x=(0.41, 0.412), y=(0, 0), z=(1.25, 1.25))  # on the basket's narrow wall
    with pytest.raises(CellError, match="in 5 attempts; in the last, it does not"):
        cell.place(Cube(), rim, np.random.default_rng(0), attempts=5, drop=True)
    with pytest.raises(CellError, match="only entities that move freely can be dropped"):
        cell.place(Table(), rim, np.random.default_rng(0), drop=True)
