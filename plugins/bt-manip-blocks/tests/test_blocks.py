"""Blocks are scattered with room, chosen by room, and belong into the row of their colour."""

import itertools

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.bt import NodeStatus
from bt_manip.cell import CellError, Region, extent, is_on
from bt_manip_blocks import (
    AreSorted,
    AreStacked,
    ChooseBase,
    ChooseBlock,
    ColouredBlock,
    FindSlot,
    ScatterBlocks,
    SortingTray,
)

from .conftest import SURFACE

SUCCESS = NodeStatus.SUCCESS


def chosen(trial, behaviour, key):
    choosing = trial(behaviour)
    assert choosing.tick() is SUCCESS
    return choosing.blackboard[key]


def put(station, colour, x, y, z=0.02):
    T_wo = spatial.pose((x, y, SURFACE + z))
    return station.cell.add(ColouredBlock(colour=colour), T_wo)


def test_blocks_lie_in_the_region_and_keep_their_distance(station, trial):
    names = chosen(trial, ScatterBlocks(each=3, blocks="{blocks}", spacing=0.07), "blocks")
    places = np.array([station.cell.pose(name).translation for name in names])
    assert [station.cell.find(name).colour for name in names] == ["red", "green", "blue"] * 3
    assert (places[:, :2] >= [0.2, -0.35]).all() and (places[:, :2] <= [0.5, 0.05]).all()
    for a, b in itertools.combinations(places, 2):
        assert np.linalg.norm((a - b)[:2]) >= 0.07
    x = np.array([station.cell.pose(name).rotation[:, 0] for name in names])
    assert np.linalg.norm(x.mean(axis=0)) < 0.8  # turned at random: one direction would give 1


@pytest.mark.parametrize("region", ["0.3;0.6;0.2;-0.2", "0.6;0.3;-0.2;0.2", "0.3;0.6;0.2"])
def test_a_region_whose_corners_are_swapped_is_refused(trial, region):
    scattering = trial(ScatterBlocks(each=1, blocks="{blocks}", region=region))
    assert scattering.fails_with("a region is x_min;x_max;y_min;y_max")


def test_a_region_without_room_is_refused_after_some_thousand_samples(trial, monkeypatch):
    samples, sample = [], Region.sample
    monkeypatch.setattr(Region, "sample", lambda *given: samples.append(1) or sample(*given))
    scattering = trial(ScatterBlocks(each=3, blocks="{blocks}", region="0.3;0.35;0.0;0.05"))
    assert scattering.fails_with("9 blocks find no room in [0.3, 0.35, 0, 0.05] with 0.08 m")
    assert 1000 <= len(samples) <= 10000


def test_blocks_lie_where_the_robot_reaches_beside_the_tray(station, trial, monkeypatch):
    """They leave 11 cm for the fingers beside it."""
    regions, sample = [], Region.sample
    monkeypatch.setattr(
        Region, "sample", lambda region, rng: regions.append(region) or sample(region, rng)
    )
    wide = [0.2, 1.2, -0.35, 0.38]  # farther than the arm reaches, and over the tray
    scattering = ScatterBlocks(each=2, blocks="{blocks}", preferred_region=wide)
    lower, upper = extent(station.cell, "tray")
    for name in chosen(trial, scattering, "blocks"):
        assert station.first.reach.reaches(station.cell, name)
    places = np.array(regions[0].squares)
    beside = np.maximum(lower[:2] - places, places - upper[:2]).max(axis=1)
    assert 0.11 <= beside.min() < 0.11 + regions[0].side


def test_blocks_that_are_scattered_again_replace_the_old_ones_and_are_not_compiled_again(
    station, trial
):
    scattering = trial(ScatterBlocks(each=2, blocks="{blocks}"))
    models = []
    for _ in range(2):
        assert scattering.tick() is SUCCESS
        models.append(station.cell.model)
    assert models[0] is models[1]
    blocks = [n for n, o in station.cell.objects.items() if isinstance(o, ColouredBlock)]
    assert blocks == ["red", "green", "blue", "red_1", "green_1", "blue_1"]
    assert scattering.blackboard["blocks"] == blocks


@pytest.mark.start("two blocks")
def test_the_block_that_lies_elsewhere_or_that_a_tower_grows_on_is_not_chosen(station, trial):
    assert chosen(trial, ChooseBlock(base="red", block="{block}"), "block") == "green"
    put(station, "blue", 0.38, 0.24, 0.025)
    station.cell.step(50)
    assert chosen(trial, ChooseBlock(on="tray", block="{block}"), "block") == "blue"


@pytest.mark.start("two blocks")
def test_the_block_with_most_room_is_chosen(station, trial):
    put(station, "blue", 0.5, 0.0)
    station.cell.step(50)
    assert chosen(trial, ChooseBlock(block="{block}"), "block") == "blue"


def test_a_tower_is_begun_where_the_nearest_neighbour_is_farthest_away(station, trial):
    for colour, x, y in (("red", 0.3, -0.1), ("green", 0.3, -0.2), ("blue", 0.45, 0.0)):
        put(station, colour, x, y)
    station.cell.step(50)
    assert chosen(trial, ChooseBase(base="{base}"), "base") == "blue"


def test_what_lies_near_a_tower_is_taken_before_it_is_in_the_way(station, trial):
    for colour, x, y in (("red", 0.3, -0.1), ("green", 0.3, -0.2), ("blue", 0.45, 0.05)):
        put(station, colour, x, y)
    station.cell.step(50)
    choosing = trial(ChooseBlock(base="red", block="{block}", place="{place}"))
    assert choosing.tick() is SUCCESS
    assert choosing.blackboard["block"] == "green"  # blue has more room
    place = choosing.blackboard["place"].translation
    assert place == pytest.approx([0.3, -0.2, SURFACE], abs=1e-3)


def test_a_block_without_room_waits_although_it_is_nearest(station, trial):
    put(station, "red", 0.3, -0.1)
    put(station, "green", 0.3, -0.2)
    for i, (x, y) in enumerate([(0.255, -0.2), (0.345, -0.2), (0.3, -0.245)]):  # around it
        put(station, ("blue", "yellow", "orange")[i], x, y)
    station.cell.step(50)
    assert chosen(trial, ChooseBlock(base="red", block="{block}"), "block") != "green"


@pytest.mark.parametrize(
    ("places", "reason"),
    [
        ([("red", -0.1, 0.02), ("green", -0.1, 0.06), ("blue", -0.1, 0.1)], ""),
        ([("red", -0.1, 0.02), ("green", -0.1, 0.06), ("blue", -0.1, 0.2)], "'blue' moves at"),
        ([("red", -0.1, 0.02), ("green", -0.2, 0.02)], "2 blocks stand on 'table'"),
    ],
)
def test_blocks_are_stacked_when_each_rests_on_the_one_below(station, trial, places, reason):
    for colour, y, z in places:
        put(station, colour, 0.3, y, z)
    station.cell.step(30)
    looking = trial(AreStacked())
    assert looking.fails_with(reason) if reason else looking.tick() is SUCCESS


def test_a_block_belongs_on_the_highest_tower_and_those_of_the_tower_where_they_are(station, trial):
    condition = trial(AreStacked()).behaviour
    put(station, "red", 0.3, -0.1)
    put(station, "blue", 0.3, -0.25)
    put(station, "green", 0.3, -0.1, 0.06)
    station.cell.step(30)
    places = condition.places()
    for name, x, y, height in (
        ("blue", 0.3, -0.1, 0.08), ("red", 0.3, -0.1, 0.0), ("green", 0.3, -0.1, 0.04),
    ):  # fmt: skip
        middle = 0.5 * (places[name].lower + places[name].upper)
        assert middle == pytest.approx(np.array([[x, y, SURFACE + height]]), abs=2e-3)
        span = (places[name].upper - places[name].lower)[0]
        assert span == pytest.approx([0.02, 0.02, 0.0])  # 1 cm to each side
    station.cell.move("green", spatial.pose((0.5, -0.1, SURFACE + 0.02)))
    station.cell.step(30)
    assert len(condition.places()["blue"].lower) == 2  # on either of the others


def test_blocks_are_sorted_when_each_stands_in_the_row_of_its_colour(station, trial):
    tray = station.cell.find("tray")
    for colour, row in (("red", "red"), ("green", "green"), ("blue", "red")):
        T_wo = station.cell.pose("tray") * tray.row(row)[0 if colour != "blue" else 1]
        put(station, colour, *T_wo.translation[:2], z=0.026)
    station.cell.step(50)
    assert trial(AreSorted()).fails_with("not in the row of their colour: blue")
    station.cell.remove("blue")
    assert trial(AreSorted()).tick() is SUCCESS


@pytest.mark.start("two blocks")
def test_slots_are_taken_one_after_another_until_the_row_is_full(station, trial):
    taken = []
    for i in range(3):
        slot = chosen(trial, FindSlot(block="red", pose="{pose}"), "pose").translation
        taken.append(tuple(slot.round(4)))
        station.cell.add(
            ColouredBlock(colour="green"), spatial.pose(slot + [0.0, 0.0, 0.021]), name=f"b{i}"
        )
    assert len(set(taken)) == 3
    assert trial(FindSlot(block="red", pose="{pose}")).fails_with("the row for red is full")


def test_what_is_no_block_and_what_is_no_tray_has_no_slot(trial):
    assert trial(FindSlot(block="table", pose="{p}")).fails_with("not a coloured block")
    assert trial(FindSlot(block="crane", pose="{p}")).fails_with("no 'crane'")


WOOD = (0.8, 0.005, 0.0001, 0.004, 1.0)  # friction, and time constant of contacts


def test_a_block_is_a_cube_of_beech():
    block = ColouredBlock(colour="violet", size=0.05)
    (geom,) = block.mjcf_model.find_all("geom")
    found = *geom.size, geom.mass, *geom.friction, *geom.solref
    assert found == pytest.approx((0.025, 0.025, 0.025, 700.0 * 0.05**3, *WOOD))
    assert block.rest_height == 0.025


def test_rows_of_a_tray_are_where_it_says():
    tray = SortingTray(colours=("yellow", "red"), slots=2)
    for colour in ("yellow", "red"):
        assert [tray.row_at(slot.translation) for slot in tray.row(colour)] == [colour] * 2
    assert tray.row("yellow")[0].translation[1] > 0 > tray.row("red")[0].translation[1]
    assert tray.row_at(np.array([0.0, 0.0851, 0.0])) is None
    assert tray.row_at(np.array([0.0601, 0.0, 0.0])) is None
    places = [slot.translation for slot in tray.row("red")]
    assert places == [pytest.approx([x, -0.0425, 0.005]) for x in (-0.03, 0.03)]
    (lower,), (upper,) = tray.row_box("red")
    assert lower == pytest.approx([-0.06, -0.085, 0.005])
    assert upper == pytest.approx([0.06, 0.0, 0.017])
    geoms = {geom.name: geom for geom in tray.mjcf_model.find_all("geom")}
    for name, corner, end in (
        ("floor_yellow", (-0.06, 0.0, 0.0), (0.06, 0.085, 0.005)),
        ("floor_red", (-0.06, -0.085, 0.0), (0.06, 0.0, 0.005)),
        ("wall_left", (-0.065, 0.085, 0.0), (0.065, 0.09, 0.017)),
        ("wall_right", (-0.065, -0.09, 0.0), (0.065, -0.085, 0.017)),
        ("wall_front", (0.06, -0.085, 0.0), (0.065, 0.085, 0.017)),
        ("wall_back", (-0.065, -0.085, 0.0), (-0.06, 0.085, 0.017)),
    ):
        one = geoms.pop(name)
        found = *(one.pos - one.size), *(one.pos + one.size), one.mass, *one.friction, *one.solref
        assert found == pytest.approx((*corner, *end, 0.05, *WOOD), abs=1e-9)
    assert not geoms
    over, on = np.array([0.06, -0.08, 0.0]), np.array([0.0, 0.0, 1e-6])
    assert (tray.row_at(over), tray.row_at(over - on)) == ("red", None)
    # At blocks in the corners and 10 cm over them, at any eighth of a turn.
    tray = SortingTray(colours=("yellow", "blue", "red"), slots=2)
    targets = [{tuple(np.round(T.translation, 6)) for T in turned} for turned in tray.tool_targets]
    corners = itertools.product((0.085, -0.085), (-0.03, 0.03), (0.035, 0.135))
    assert targets == [{(x, y, z)} for y, x, z in corners]
    for k, T in enumerate(tray.tool_targets[-1]):
        assert T.rotation[:, 0] == pytest.approx([np.cos(k * np.pi / 4), np.sin(k * np.pi / 4), 0])
        assert T.rotation[2, 2] == -1.0


def test_blocks_on_the_underside_of_a_tray_are_not_sorted(station, trial):
    tray = station.cell.find("tray")
    turned = pin.SE3(pin.rpy.rpyToMatrix(np.pi, 0.0, 0.0), np.array([0.0, 0.0, 0.017]))
    T_wt = station.cell.pose("tray") * turned
    station.cell.move("tray", T_wt)
    put(station, "red", *(T_wt * tray.row("red")[0]).translation[:2], z=0.038)
    station.cell.step(50)
    assert is_on(station.cell, "red", "tray")
    assert trial(AreSorted()).fails_with("not in the row of their colour: red")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ColouredBlock(colour="rde"), "no colour 'rde'; did you mean 'red'"),
        (lambda: ColouredBlock(size=0.0), "size must be"),
        (lambda: SortingTray(colours=("red", "red")), "one row for each"),
        (lambda: SortingTray(colours=("rde",)), "no colour 'rde'"),
        (lambda: SortingTray(slots=0), "slots must be a whole number of at least 1, got 0"),
        (lambda: SortingTray().row("violet"), "no row for 'violet'"),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(CellError, match=message):
        make()


def test_a_block_that_vanishes_is_neither_sorted_nor_stacked_until_blocks_are_added(station, trial):
    tray = station.cell.find("tray")
    for slot in tray.row("red")[:2]:
        put(station, "red", *(station.cell.pose("tray") * slot).translation[:2], z=0.026)
    station.cell.step(50)
    are_sorted, are_stacked = trial(AreSorted()), trial(AreStacked())
    assert are_sorted.tick() is SUCCESS
    station.cell.remove("red_1")
    assert are_sorted.fails_with("gone from the cell: red_1")
    assert are_sorted.behaviour.places()["red_1"] is None
    assert are_stacked.fails_with("gone from the cell: red_1")
    assert trial(ScatterBlocks(blocks="{b}")).tick() is SUCCESS
    assert are_sorted.fails_with("not in the row of their colour: red, green, blue")


def test_when_all_were_removed_those_added_later_are_all(station, trial):
    are_stacked = trial(AreStacked())
    for name in (put(station, "red", 0.3, y) for y in (-0.2, -0.1)):
        station.cell.remove(name)
    assert are_stacked.fails_with("the cell has no coloured blocks")
    put(station, "green", 0.3, -0.3)
    station.cell.step(50)
    assert are_stacked.tick() is SUCCESS


def test_another_block_does_not_stand_for_one_that_vanished(station, trial):
    for i in range(3):
        put(station, "red", 0.3, 0.1 * i - 0.2)
    are_stacked = trial(AreStacked())
    station.cell.remove("red_1")
    put(station, "green", 0.3, -0.3)
    assert are_stacked.fails_with("gone from the cell: red_1")
    put(station, "red", 0.3, -0.1)  # it is named red_1
    station.cell.step(50)
    assert are_stacked.fails_with("4 blocks stand on 'table'")


def test_the_base_of_a_tower_must_stand_on_its_support(station, trial):
    put(station, "red", 0.3, -0.1, z=0.2)
    station.cell.step(5)
    assert trial(AreStacked()).tick() is not SUCCESS
