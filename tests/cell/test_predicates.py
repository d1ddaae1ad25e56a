"""At rest, in a container, on a support: judged by contacts, forces and positions."""

import numpy as np
import pytest

from bt_manip.cell import (
    Basket,
    Cell,
    CellError,
    Cube,
    Table,
    at_rest,
    extent,
    is_in,
    is_on,
    is_within,
    why_not_at_rest,
    why_not_in,
    why_not_on,
)
from bt_manip.cell.objects import Bottle, Box, ModelObject, Tray
from bt_manip.cell.predicates import surrounds
from bt_manip.spatial import pose

TOP = 1.015  # [m] height of the table
FLOOR = 0.021  # [m] above the bottom of the basket that objects are let go at


@pytest.fixture
def cell():
    cell = Cell()
    cell.add(Table(), pose((0.0, 0.0, 0.0)))
    cell.add(Basket(), pose((0.0, 0.0, TOP)))
    return cell


def put(cell, entity, x, y, z, name=None, settle=400, **keywords):
    name = cell.add(entity, pose((x, y, TOP + z)), name=name, **keywords)
    cell.step(settle)
    return name


@pytest.fixture
def inside(cell):
    return put(cell, Cube(), 0.0, 0.0, 0.025 + FLOOR, "inside")


def test_a_cube_in_the_basket_or_on_a_cube_there_is_in_it_and_on_what_carries_it(cell, inside):
    assert at_rest(cell, inside) and is_in(cell, inside, "basket")
    assert not is_in(cell, inside, "table")
    put(cell, Cube(), 0.0, 0.0, 0.098, "upper")
    assert is_in(cell, "upper", "basket") and is_on(cell, "upper", "inside")
    assert why_not_on(cell, "upper", "basket") == "'upper' does not touch 'basket'"
    assert why_not_on(cell, "inside", "upper") == "'upper' does not carry 'inside'"


def test_a_cube_on_the_table_is_on_it_until_it_is_moved_and_not_in_the_basket(cell):
    put(cell, Cube(), -0.3, 0.0, 0.026, "cube")
    assert is_on(cell, "cube", "table")
    assert why_not_in(cell, "cube", "basket") == "'cube' touches 'table'"
    cell.move("cube", pose((-0.3, 0.0, TOP + 0.2)))
    assert why_not_on(cell, "cube", "table") == "'cube' touches nothing"


def test_a_cube_that_falls_in_the_basket_is_within_it_only(cell):
    put(cell, Cube(), 0.0, 0.0, 0.08, "cube", settle=0)
    assert why_not_in(cell, "cube", "basket") == "'cube' touches nothing"
    cell.step(50)
    assert not at_rest(cell, "cube") and not is_in(cell, "cube", "basket")
    assert "moves at" in why_not_in(cell, "cube", "basket") == why_not_at_rest(cell, "cube")
    assert is_within(cell, "cube", "basket")
    cell.move("cube", pose((0.0, 0.0, TOP + 0.4)))
    assert not is_within(cell, "cube", "basket")


def test_a_board_over_the_rim_is_on_the_basket_and_not_in_it(cell):
    lower, upper = extent(cell, "basket")
    x, y, _ = upper - lower
    put(cell, Box(size=(x + 0.02, y + 0.02, 0.01)), 0.0, 0.0, upper[2] - TOP + 0.006, "lid")
    assert is_on(cell, "lid", "basket")
    assert why_not_in(cell, "lid", "basket") == "'lid' does not rest on the inside of 'basket'"
    put(cell, Cube(), 0.0, 0.0, upper[2] - TOP + 0.037, "cube")
    assert not is_in(cell, "cube", "basket")


def test_what_stands_on_a_tray_is_in_it_however_tall_it_is(cell):
    cell.add(Tray(), pose((0.0, -0.4, TOP)))
    bottle = Bottle()
    put(cell, bottle, 0.0, -0.4, bottle.rest_height + 0.007, "bottle")
    assert is_in(cell, "bottle", "tray") and is_on(cell, "bottle", "tray")


def test_where_the_basket_is_now_counts(cell, inside):
    assert is_in(cell, inside, "basket")
    for predicate in (is_in, is_on):
        with pytest.raises(CellError, match="'ball'"):
            predicate(cell, "ball", "basket")
    cell.move("basket", pose((0.4, 0.0, TOP)))
    cell.step(400)
    assert why_not_in(cell, inside, "basket") == "'inside' touches 'table'"
    cell.remove("basket")
    with pytest.raises(CellError, match="basket"):
        is_in(cell, inside, "basket")


def test_a_cube_under_the_rim_outside_of_the_basket_is_not_in_it(cell):
    """The walls lean outwards: the rim is over the cube, which touches only board and wall."""
    upper = extent(cell, "basket")[1]
    put(cell, Box(size=(0.1, 0.1, 0.003)), upper[0] + 0.04, 0.0, 0.0016, "board", settle=100)
    put(cell, Box(size=(0.01, 0.01, 0.01)), upper[0] - 0.0075, 0.0, 0.0082, "cube", settle=500)
    assert {"basket", "board"} == {b.partition("/")[0] for b in cell.contacts.partners("cube")}
    assert not is_in(cell, "cube", "basket")


@pytest.mark.parametrize("quantity", ["qpos", "qvel"])
def test_nothing_holds_in_a_state_that_is_not_finite(cell, quantity):
    inside = put(cell, Cube(), 0.0, 0.0, 0.025 + FLOOR, "inside", settle=100)
    getattr(cell.data, quantity)[0] = np.nan
    reason = "the state of the cell is not finite"
    assert why_not_at_rest(cell, inside) == why_not_in(cell, inside, "basket") == reason
    assert why_not_on(cell, inside, "basket") == reason
    assert not (at_rest(cell, inside) or is_in(cell, inside, "basket"))


def test_a_rod_that_topples_slowly_is_not_at_rest(model):
    """It is balanced on an edge 0.12 degrees past the unstable equilibrium."""
    rod = model('<geom type="box" size=".005 .005 .25" pos="0 0 .25" mass=".1"/>')
    cell, angle = Cell(), np.arctan(0.005 / 0.25) + 2e-3
    height = 0.005 * np.sin(angle) + 1e-5
    T_wo = pose((0.0, 0.0, height), (np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0))
    cell.add(rod, T_wo, name="rod", free=True)
    top = np.array([0.0, 0.0, 0.5])
    cell.step(50)  # its edge comes to rest on the floor
    while cell.pose("rod").rotation[2, 2] > 0.5:
        cell.step(4)
        before = cell.pose("rod")
        cell.step()
        speed = np.linalg.norm(cell.pose("rod") * top - before * top) / cell.dt  # [m/s]
        assert speed < 2e-3 or not at_rest(cell, "rod")
    assert 0.3 < cell.time < 2.0


@pytest.fixture
def model(tmp_path):
    """Make an object of geoms in the text of a model."""

    def make(*geoms):
        file = tmp_path / "model.xml"
        file.write_text(f"<mujoco><worldbody><body>{''.join(geoms)}</body></worldbody></mujoco>")
        return ModelObject(str(file))

    return make


def posts(directions, radius=0.055, width=0.003, height=0.03, z=0.036):
    """Give the geoms of upright posts in a circle, at angles [rad]."""
    return [
        f'<geom type="cylinder" size="{width} {height}" '
        f'pos="{radius * np.cos(a):.5f} {radius * np.sin(a):.5f} {z}"/>'
        for a in directions
    ]


@pytest.mark.parametrize(("count", "holds"), [(6, False), (12, True)])
def test_gaps_that_the_object_does_not_fit_through_are_closed(count, holds, model):
    """Between 6 posts are 52 mm, between 12 are 23 mm; the cube is 30 mm wide."""
    floor = '<geom type="box" size=".06 .06 .003" pos="0 0 .003"/>'
    grid = model(floor, *posts(np.arange(count) * 2.0 * np.pi / count))
    cell = Cell()
    with cell.editing():
        cell.add(Table(), pose((0.0, 0.0, 0.0)))
        cell.add(grid, pose((0.0, 0.0, TOP)), name="grid", free=False)
        cell.add(Box(size=(0.03,) * 3), pose((0.0, 0.0, TOP + 0.022)), name="cube", free=True)
        cell.add(
            Box(size=(0.2, 0.1, 0.005)), pose((0.17, 0.0, TOP + 0.003)), name="board", free=True
        )
        cell.add(Box(size=(0.03,) * 3), pose((0.085, 0.0, TOP + 0.022)), name="beside", free=True)
    cell.step(500)
    assert is_in(cell, "cube", "grid") is holds
    assert not is_in(cell, "beside", "grid")


FOOT_CUP = """
<geom type="box" size=".12 .12 .005" pos="0 0 .005"/>
<geom type="box" size=".04 .003 .04" pos="0 .037 .05"/>
<geom type="box" size=".04 .003 .04" pos="0 -.037 .05"/>
<geom type="box" size=".003 .034 .04" pos=".037 0 .05"/>
<geom type="box" size=".003 .034 .04" pos="-.037 0 .05"/>"""


def test_the_inside_of_a_cup_is_in_it_and_its_foot_is_not(model):
    cell, angle = Cell(), 0.5
    T_wc = pose((0.3, -0.2, TOP), (np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)))
    with cell.editing():
        cell.add(Table(), pose((0.0, 0.0, 0.0)))
        cell.add(model(FOOT_CUP), T_wc, name="cup", free=False)
        for name, x, y in (("inside", 0.0, 0.0), ("beside", 0.08, 0.0), ("corner", 0.1, 0.1)):
            T_wo = T_wc * pose((x, y, 0.021))
            cell.add(Box(size=(0.02, 0.02, 0.02)), T_wo, name=name, free=True)
    cell.step(500)
    assert is_in(cell, "inside", "cup") and is_within(cell, "inside", "cup")
    for name in ("beside", "corner"):
        assert why_not_in(cell, name, "cup") == f"'{name}' is not inside 'cup'"
        assert not is_within(cell, name, "cup")


@pytest.mark.parametrize(
    ("velocity", "acceleration", "reason"),
    [
        ({1: -0.0045}, {0: 0.9}, ""),
        ({1: -0.0055}, {}, "moves at 5.5 mm/s"),
        ({4: 0.19}, {}, ""),
        ({4: 0.21}, {}, "turns at 0.21 rad/s"),
        ({2: 0.004, 4: 0.19998}, {}, ""),
        ({3: 0.09}, {}, ""),
        ({3: 0.11}, {}, "turns: its fastest corner moves at 11.0 mm/s"),
        ({0: 0.004}, {1: 1.1}, "touches nothing"),
        ({3: 0.05}, {3: 0.19}, ""),  # 2 cm/s^2 at 0.1 m
        ({3: 0.05}, {3: 0.21}, "topples: its fastest corner moves at 5.0 mm/s, ever faster"),
        ({3: 0.009}, {3: 0.3}, ""),
        ({0: 1.1e-3}, {0: 0.03}, "topples: its fastest corner moves at 1.1 mm/s, ever faster"),
    ],
)
def test_an_object_is_at_rest_below_limits_of_its_motion(velocity, acceleration, reason):
    """Of linear (0 to 2) and angular motion (3 to 5) some components are not zero."""
    velocity, acceleration = (
        np.array([given.get(i, 0.0) for i in range(6)]) for given in (velocity, acceleration)
    )
    cell = Cell()  # a rod of 20 cm along the y axis of the world
    T_wo = pose((0.3, 0.0, 1.0), (0.5, -0.5, 0.5, 0.5))
    size = np.full(3, 0.01) + 0.19 * np.abs(T_wo.rotation.T[:, 1])
    cell.add(Box(size=tuple(size)), T_wo, name="rod", free=True)
    local = [T_wo.rotation.T @ given[3:] for given in (velocity, acceleration)]
    cell.data.qvel[:6] = [*velocity[:3], *local[0]]
    cell.data.qacc[:6] = [*acceleration[:3], *local[1]]
    assert why_not_at_rest(cell, "rod") == (reason and f"'rod' {reason}")


@pytest.mark.parametrize(("share", "carried"), [(0.3, True), (0.2, False)])
def test_a_support_carries_at_least_a_quarter_of_the_weight(share, carried):
    cell = Cell()
    with cell.editing():
        for name, x in (("left", 0.0), ("right", 0.2)):
            cell.add(Box(size=(0.004, 0.05, 0.04)), pose((x, 0.0, 0.02)), name=name, free=False)
        at = pose((0.2 * (1.0 - share), 0.0, 0.0455))
        cell.add(Box(size=(0.4, 0.04, 0.01)), at, name="plank", free=True)
    cell.step(500)
    assert is_on(cell, "plank", "left") == carried and is_on(cell, "plank", "right")


def test_a_place_is_surrounded_where_something_is_in_each_of_16_directions(model):
    cell, T = Cell(), pose((0.3, 0.2, 1.0), (0.5, 0.5, 0.5, 0.5))
    cage = model(*posts(np.arange(16) * np.pi / 8, width=0.001, z=0.0))
    cell.add(cage, T, name="cage", free=False)
    place, types = (T.translation[np.newaxis], T.rotation[:, 2]), cell.model.geom_contype
    types[:], cell.model.geom_conaffinity[:] = 1, 0
    assert surrounds(cell, "cage", *place) and surrounds(cell, "cage", *place, within=0.06)
    assert not surrounds(cell, "cage", *place, within=0.05)  # at 0.055 m
    for post in np.flatnonzero(cell.contacts.geoms("cage")):
        types[post] = 0  # it does not collide
        assert not surrounds(cell, "cage", *place)
        types[post] = 1


@pytest.mark.parametrize(
    ("gap", "closed"), [((-19, 23), True), ((-23, 19), True), ((-21, 21), False)]
)
def test_a_gap_is_closed_for_an_object_that_is_wider_or_higher(gap, closed, model):
    """The front of a box is open between two edges [mm]; the object is 40 mm wide, 60 mm high."""
    box, (left, right) = '<geom type="box" size="{} {} .1" pos="{} {} 0"/>'.format, gap
    sides = [box(0.003, 0.1, -0.1, 0), box(0.1, 0.003, 0, 0.1), box(0.1, 0.003, 0, -0.1)]
    plates = [
        box(0.003, 0.5 * (100 + left) / 1000, 0.1, 0.5 * (left - 100) / 1000),
        box(0.003, 0.5 * (100 - right) / 1000, 0.1, 0.5 * (right + 100) / 1000),
    ]
    bar = '<geom type="box" size=".003 .05 .003" pos=".1 0 .026"/>'
    cell, points = Cell(), np.array([[0.2, 0.1, 1.0], [0.2, 0.1, 1.06]])
    with cell.editing():
        for name, geoms in (("open", plates), ("barred", [*plates, bar])):
            cell.add(model(*sides, *geoms), pose(points[0]), name=name, free=False, overlap=1.0)
    assert not surrounds(cell, "open", points) and not surrounds(cell, "barred", points)
    assert surrounds(cell, "open", points, width=0.04) is closed
    assert surrounds(cell, "barred", points, width=0.01)


@pytest.mark.parametrize(("wall", "inside"), [(0.004, False), (0.006, True)])
def test_what_a_rim_of_5_mm_surrounds_is_inside(cell, wall, inside):
    cell.add(Tray(size=(0.2, 0.2, 0.01 + wall), wall=0.01), pose((0.0, -0.3, TOP)))
    put(cell, Cube(), 0.03, -0.32, 0.036, "cube")
    assert is_in(cell, "cube", "tray") is inside and is_on(cell, "cube", "tray")


def test_at_the_turning_point_of_a_bounce_nothing_is_at_rest(cell):
    cell.add(Cube(), pose((-0.3, 0.0, TOP + 0.05)), name="cube")
    steps = []
    for _ in range(600):
        cell.step()
        steps.append(is_on(cell, "cube", "table"))
    assert steps[-1] and False not in steps[steps.index(True) :]
