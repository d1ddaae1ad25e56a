"""Buttons, drawers, pegs and boards move and have sizes as they say."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell, CellError, extent
from bt_manip.spatial import pose
from bt_manip_impedance import Drawer, HoleBoard, Peg, PushButton
from bt_manip_impedance.drawer import SIZE

TRAVEL, FORCE = 0.008, 10.0  # of the button
OPENING, RESISTANCE = 0.2, 5.0  # of the drawer


@pytest.fixture
def cell() -> Cell:
    cell = Cell()
    cell.add(PushButton(travel=TRAVEL, force=FORCE), pose((0, 0, 0)))
    return cell


def press(cell: Cell, force: float) -> PushButton:
    joint = cell.model.joint("push_button/press")
    cell.data.qfrc_applied[joint.dofadr[0]] = force
    cell.step(300)
    button = cell.entities["push_button"]
    return button


def test_above_the_preload_the_depth_is_proportional_to_the_force_up_to_the_travel(cell):
    # A fifth of the force lifts it off the stop; the rest is spread over the travel.
    for force, depth in ((0.0, 0.0), (1.5, 0.0), (4.0, 0.002), (8.0, 0.006), (12.0, TRAVEL)):
        assert press(cell, force).depth == pytest.approx(depth, abs=1e-4)


def test_it_is_pressed_below_half_of_its_travel(cell):
    assert not press(cell, 5.5).pressed
    assert press(cell, 6.5).pressed


def test_a_released_cap_is_as_high_as_the_button_says_and_sinks_into_the_housing(cell):
    button = cell.entities["push_button"]
    cap = cell.model.geom("push_button/cap").id
    height, half = cell.data.geom_xpos[cap][2], cell.model.geom_size[cap][1]
    assert height + half == pytest.approx(button.height)
    assert height - half <= button.height - TRAVEL


def pulled(force: float, steps: int = 600) -> Drawer:
    cell = Cell()
    cell.add(Drawer(travel=OPENING, resistance=RESISTANCE), pose((0, 0, 0)))
    drawer = cell.find("drawer")
    cell.data.qfrc_applied[cell.model.joint("drawer/slide").dofadr[0]] = force
    cell.step(steps)
    return drawer


def test_a_force_larger_than_the_friction_opens_a_drawer_to_its_stop():
    assert pulled(0.8 * RESISTANCE).opening == pytest.approx(0.0, abs=2e-4)
    assert 0.02 < pulled(2.0 * RESISTANCE, 200).opening < OPENING
    assert pulled(6.0 * RESISTANCE, 2000).opening == pytest.approx(OPENING, abs=5e-3)


def test_the_handle_moves_with_the_drawer():
    closed, open_ = pulled(0.0), pulled(4.0 * RESISTANCE)
    moved = open_.T_oh.translation - closed.T_oh.translation
    assert moved == pytest.approx([closed.opening - open_.opening, 0.0, 0.0])


@pytest.mark.parametrize(
    ("kind", "parameters", "message"),
    [
        (PushButton, {"travel": 0.0}, "travel must be"),
        (PushButton, {"force": -1.0}, "force must be"),
        (Drawer, {"travel": 0.3}, "travel"),
        (Drawer, {"resistance": 0.0}, "resistance"),
    ],
)
def test_impossible_parameters_are_refused(kind, parameters, message):
    with pytest.raises(CellError, match=message):
        kind(**parameters)


def test_a_closed_drawer_is_a_box_of_its_size_and_the_same_on_both_sides():
    cell = Cell()
    cell.add(Drawer(), pose((0, 0, 0)))
    cabinet = cell.model.geom_bodyid == cell.model.body("drawer/cabinet").id
    half = cell.model.geom_size[cabinet]
    lower, upper = cell.data.geom_xpos[cabinet] - half, cell.data.geom_xpos[cabinet] + half
    assert upper.max(axis=0) - lower.min(axis=0) == pytest.approx(SIZE)
    boxes = np.column_stack((cell.data.geom_xpos, cell.model.geom_size)).round(9) + 0.0
    mirrored = boxes * (1, -1, 1, 1, 1, 1) + 0.0
    assert {*map(tuple, boxes)} == {*map(tuple, mirrored)}


def test_a_peg_falls_through_a_hole_that_is_wider_and_stays_on_one_that_is_not():
    for hole, falls in ((0.0165, True), (0.013, False)):
        cell, peg = Cell(), Peg(radius=0.015)
        cell.add(HoleBoard(hole=hole), pose((0, 0, 0.5)))
        cell.add(peg, pose((0, 0, 0.54 + peg.rest_height + 1e-3)))
        cell.step(400)
        assert (cell.pose("peg").translation[2] < 0.4) == falls


def test_a_board_is_solid_but_for_its_hole_wherever_that_is():
    cell, hole, offset = Cell(), 0.0165, (0.02, -0.03)
    cell.add(HoleBoard(hole=hole, offset=offset), pose((0, 0, 0)), name="board", free=False)
    for x, y in np.random.default_rng(0).uniform(-0.08, 0.08, (2000, 2)):
        away = np.hypot(x - offset[0], y - offset[1])
        start, down = np.array([x, y, 1.0]), np.array([0.0, 0.0, -1.0])
        hit = mujoco.mj_ray(cell.model, cell.data, start, down, None, 1, -1, np.zeros(1, np.int32))
        if not hole < away < hole / np.cos(np.pi / 16):  # between circle and polygon
            assert (hit == pytest.approx(0.96)) == (away > hole)


def test_the_tool_holds_the_end_of_a_peg_in_the_hole_or_above_the_board():
    groups = HoleBoard(size=(0.2, 0.2, 0.05)).tool_targets
    for group, end in zip(groups, (0.02, 0.05, 0.08), strict=True):  # 8 cm below the tool
        for T in group:
            assert T.translation == pytest.approx([0.0, 0.0, end + 0.08])
            assert T.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0])
        yaws = [np.degrees(np.arctan2(T.rotation[1, 0], T.rotation[0, 0])) for T in group]
        assert sorted(yaws) == pytest.approx([0.0, 45.0, 90.0, 135.0])


def test_a_board_is_refused_up_to_the_width_of_which_it_is_told():
    def board(width):
        return HoleBoard(size=(width, width, 0.04), offset=(0.01, -0.02))

    with pytest.raises(CellError, match="needs a board wider than ") as refused:
        board(0.05)
    width = float(str(refused.value).split()[-2])
    board(width + 1e-5)
    with pytest.raises(CellError, match="wider than"):
        board(width - 1e-5)


@pytest.mark.parametrize(
    ("thing", "lengths"),
    [
        (HoleBoard(size=(0.2, 0.15, 0.05)), (0.2, 0.15, 0.05)),
        (Peg(radius=0.01, length=0.08), (0.02, 0.02, 0.08)),
    ],
)
def test_they_are_as_long_wide_and_high_as_they_say(thing, lengths):
    cell = Cell()
    cell.add(thing, pose((0, 0, 1)), name="thing", free=False)
    lower, upper = extent(cell, "thing")
    assert upper - lower == pytest.approx(lengths)


def test_the_handle_of_an_open_drawer_is_before_it_and_tools_reach_it_from_above():
    drawer = pulled(25.0, 200)
    assert 0.01 < drawer.opening < OPENING and drawer.speed > 0.01
    assert drawer.T_oh.translation == pytest.approx([-0.15 - 0.04 - drawer.opening, 0.0, 0.06])
    at = (-0.19, 0.18), (-0.19, 0.06), (-0.37, 0.06), (-0.37, 0.09)  # over, closed, open, over
    for poses, (x, z) in zip(drawer.tool_targets, at, strict=True):
        for T, side in zip(poses, (1.0, -1.0), strict=True):
            assert T.translation == pytest.approx([x, 0.0, z])
            assert T.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0])
            assert T.rotation[:, 0] == pytest.approx([side, 0.0, 0.0])


def test_a_drawer_accelerates_as_its_mass_friction_and_damping_say():
    # m x'' + 10 x' = 25 - 5 N, which gives x = 2 (t - T (1 - exp(-t / T))) with T = m / 10.
    t, T = 0.2, 0.15
    assert pulled(25.0, 200).opening == pytest.approx(2.0 * (t - T + T * np.exp(-t / T)), rel=0.03)
