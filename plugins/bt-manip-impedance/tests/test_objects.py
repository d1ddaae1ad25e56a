"""Buttons, drawers, pegs and boards move and have sizes as they say."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell, CellError, extent
from bt_manip.spatial import pose
from bt_manip_impedance import Drawer, HoleBoard, Peg, PushButton

TRAVEL = 0.008  # [m] of the button by default; 10 N at its end
OPENING, RESISTANCE = 0.2, 5.0  # [m, N] of the drawer by default


@pytest.fixture
def cell() -> Cell:
    cell = Cell()
    cell.add(PushButton(), pose((0, 0, 0)))
    return cell


def test_above_the_preload_the_depth_is_proportional_to_the_force_up_to_the_travel(cell):
    # A fifth of the force lifts it off the stop; the rest is spread over the travel.
    button, joint = cell.entities["push_button"], cell.model.joint("push_button/press")
    for force, depth in ((0.0, 0.0), (1.5, 0.0), (4.0, 0.002), (8.0, 0.006), (12.0, TRAVEL)):
        cell.data.qfrc_applied[joint.dofadr[0]] = force
        cell.step(300)
        assert button.depth == pytest.approx(depth, abs=1e-4)


def test_a_suddenly_pressed_cap_overshoots_as_its_mass_spring_and_damper_say(cell):
    # 0.05 kg, 1000 N/m and 1 N s/m; 4 N above the preload.
    cell.data.qfrc_applied[cell.model.joint("push_button/press").dofadr[0]] = 6.0
    depths = []
    for _ in range(40):
        cell.step(1)
        depths.append(cell.entities["push_button"].depth)
    ratio = 0.5 / np.sqrt(0.05 * 1000.0)
    overshoot = np.exp(-np.pi * ratio / np.sqrt(1.0 - ratio**2))
    assert max(depths) == pytest.approx(0.004 * (1.0 + overshoot), rel=0.02)
    assert np.argmax(depths) + 1 == pytest.approx(1e3 * np.pi * np.sqrt(0.05 / 1000.0), abs=1.0)


def test_a_press_counts_from_95_percent_of_the_travel_and_again_after_half_of_it(cell):
    button = cell.entities["push_button"]
    for share, pressed, presses in (
        (0.94, True, 0), (0.96, True, 1), (0.52, True, 1), (0.97, True, 1), (0.49, False, 1),
        (0.94, True, 1), (0.96, True, 2),
    ):  # fmt: skip
        cell.data.qpos[0], cell.data.time = share * TRAVEL, share
        button.after_substep(None, None)
        assert (button.pressed, button.presses) == (pressed, presses)
    assert button.pressed_at == 0.96


def test_tools_reach_a_button_from_above_in_all_directions_on_its_cap_and_over_it(cell):
    groups = cell.entities["push_button"].tool_targets
    for group, z in zip(groups, (0.02 + TRAVEL + 0.002, 0.02 + TRAVEL + 0.072), strict=True):
        assert np.array([T.translation for T in group]) == pytest.approx(np.tile((0, 0, z), (8, 1)))
        assert all(T.rotation[2, 2] == pytest.approx(-1.0) for T in group)
        yaws = [np.arctan2(T.rotation[1, 0], T.rotation[0, 0]) for T in group]
        assert np.sort(np.degrees(yaws).round(6) % 360) == pytest.approx(np.arange(8) * 45.0)


def test_a_released_cap_is_as_high_as_the_button_says_and_sinks_into_the_housing(cell):
    button = cell.entities["push_button"]
    cap = cell.model.geom("push_button/cap").id
    height, half = cell.data.geom_xpos[cap][2], cell.model.geom_size[cap][1]
    assert height + half == pytest.approx(button.height)
    assert height - half <= button.height - TRAVEL


def pulled(force: float, steps: int = 600) -> Drawer:
    cell = Cell()
    cell.add(Drawer(), pose((0, 0, 0)))
    drawer = cell.find("drawer")
    cell.data.qfrc_applied[cell.model.joint("drawer/slide").dofadr[0]] = force
    cell.step(steps)
    return drawer


def test_a_force_larger_than_the_friction_opens_a_drawer_to_its_stop():
    assert pulled(0.8 * RESISTANCE).opening == pytest.approx(0.0, abs=2e-4)
    assert pulled(6.0 * RESISTANCE, 1000).opening == pytest.approx(OPENING, abs=5e-3)


@pytest.mark.parametrize(
    ("kind", "name", "refused", "accepted"),
    [
        (PushButton, "travel", (0.0, 0.0201), (1e-3, 0.02)),
        (PushButton, "force", (-1.0, 0.0), (0.5,)),
        (Drawer, "travel", (0.0, 0.281), (1e-3, 0.279)),
        (Drawer, "resistance", (0.0,), (0.5,)),
    ],
)
def test_impossible_parameters_are_refused(kind, name, refused, accepted):
    for value in refused:
        with pytest.raises(CellError, match=f"{name} must be"):
            kind(**{name: value})
    assert all(kind(**{name: value}).parameters[name] == value for value in accepted)


def test_a_drawer_has_boards_of_10_mm_with_2_mm_between_its_front_and_the_cabinet():
    cell = Cell()
    cell.add(Drawer(), pose((0, 0, 0)))
    points = np.random.default_rng(0).uniform((-0.23, -0.14, -0.02), (0.17, 0.14, 0.14), (20000, 3))
    model, data = cell.model, cell.data

    def within(lower, upper, of=points):
        return np.all((of >= lower) & (of <= upper), axis=-1)

    own = model.geom_bodyid > 0  # not the floor
    size, at = model.geom_size[own][:, None], data.geom_xpos[own][:, None]
    solid = within(-size, size, points - at).any(axis=0)
    cabinet = within((-0.15, -0.12, 0.0), (0.15, 0.12, 0.12))
    cabinet &= ~within((-1.0, -0.11, 0.01), (0.14, 0.11, 0.11))
    front = within((-0.15, -0.108, 0.012), (-0.14, 0.108, 0.108))
    tray = within((-0.15, -0.108, 0.012), (0.13, 0.108, 0.06))  # to half of its height
    tray &= ~within((-0.15, -0.098, 0.022), (0.13, 0.098, 0.06))
    handle = within((-0.21, -0.008, 0.04), (-0.15, 0.008, 0.08))
    np.testing.assert_array_equal(solid, cabinet | front | tray | handle)
    assert model.body_subtreemass[model.body("drawer/tray").id] == pytest.approx(1.5)


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
    ("thing", "lengths", "mass"),
    [
        (HoleBoard(size=(0.2, 0.15, 0.05), mass=0.7), (0.2, 0.15, 0.05), 0.7),
        (HoleBoard(), (0.16, 0.16, 0.04), 0.9),
        (Peg(radius=0.01, length=0.08, mass=0.1), (0.02, 0.02, 0.08), 0.1),
        (Peg(), (0.03, 0.03, 0.09), 0.08),
    ],
)
def test_they_are_as_long_wide_high_and_heavy_as_they_say(thing, lengths, mass):
    cell = Cell()
    cell.add(thing, pose((0, 0, 1)), name="thing", free=True)
    lower, upper = extent(cell, "thing")
    assert upper - lower == pytest.approx(lengths)
    assert cell.model.body_subtreemass[cell.body_id("thing")] == pytest.approx(mass)


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
