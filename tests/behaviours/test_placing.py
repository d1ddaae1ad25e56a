"""Behaviours that set things down: on others, at poses, with room for the fingers."""

from itertools import product

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.behaviours import (
    Destination,
    Hover,
    Lift,
    PlaceAt,
    PlaceOn,
    Reach,
    centre_pose,
    top_grasp_poses,
    yaw_of,
)
from bt_manip.behaviours.support import find_support
from bt_manip.bt import NodeStatus
from bt_manip.cell import Cell, CellError, Cube
from bt_manip.cell.objects import Box, Shelf
from bt_manip.grasping import GripperClearance, with_clearance
from bt_manip.grippers import GRIP_DEPTH
from bt_manip.testing.end_states import assert_tower

RUNNING = NodeStatus.RUNNING
PLACE = "0.35;-0.15;1.015"


@pytest.fixture
def beside_another(with_the_cube):
    yaw = 0.4
    turn = (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2))
    with_the_cube.cell.add(Cube(), spatial.pose((0.4, -0.15, 1.04), turn), name="other")
    with_the_cube.cell.step(100)
    return with_the_cube


def test_place_on_leaves_a_tower(beside_another, trial):
    placing = trial(PlaceOn(object="cube", support="other"))
    assert placing.tick() is RUNNING
    placing.tick_until("SUCCESS", timeout=5.0)
    trial(Lift(height=0.1)).tick_until("SUCCESS")
    cell = beside_another.cell
    cell.step(500)
    assert_tower(cell, ["other", "cube"], on="table")
    off = cell.pose("cube").translation - cell.pose("other").translation
    assert np.linalg.norm(off[:2]) < 2e-3
    quarter = (yaw_of(cell.pose("cube")) - yaw_of(cell.pose("other"))) / (np.pi / 2)
    assert abs(quarter - round(quarter)) < 0.02


def test_place_on_takes_a_free_place_where_the_middle_is_occupied(with_the_cube, trial):
    cell = with_the_cube.cell
    cell.add(Box(size=(0.3, 0.3, 0.02)), spatial.pose((0.45, -0.1, 1.025)), name="tray", free=False)
    cell.add(Cube(), spatial.pose((0.45, -0.1, 1.06)), name="other")
    cell.step(100)
    trial(PlaceOn(object="cube", support="tray")).tick_until("SUCCESS", timeout=8.0)
    off = cell.pose("cube").translation - cell.pose("other").translation
    assert 0.05 < np.linalg.norm(off[:2]) < 0.12 and abs(off[2]) < 2e-3


def test_place_on_takes_a_place_within_reach(with_the_cube, trial):
    cell = with_the_cube.cell
    cell.add(Box(size=(0.9, 0.1, 0.02)), spatial.pose((1.0, 0.25, 1.025)), name="rail", free=False)
    trial(PlaceOn(object="cube", support="rail")).tick_until("SUCCESS", timeout=8.0)
    assert 0.55 < cell.pose("cube").translation[0] < 0.9


def test_place_on_a_full_support_says_so(with_the_cube, trial):
    cell = with_the_cube.cell
    cell.add(Box(size=(0.1, 0.1, 0.02)), spatial.pose((0.45, -0.1, 1.025)), name="tray", free=False)
    cell.add(Cube(), spatial.pose((0.45, -0.1, 1.06)), name="other")
    assert trial(PlaceOn(object="cube", support="tray")).fails_with("no free place on 'tray'")


@pytest.mark.parametrize("size", [(0.04, 0.2), (0.2, 0.04)])
def test_free_places_are_2_cm_from_neighbours_on_the_side_where_they_are(size):
    cell = Cell()
    cell.add(Box(size=(1.0, 1.0, 0.02)), spatial.pose((0, 0, 0.01)), name="tray", free=False)
    cell.add(Box(size=(*size, 0.04)), spatial.pose((2.0, 0.0, 0.02)), name="bar")
    support = find_support(cell, "tray")
    empty = list(support.free_offsets(cell, "bar"))
    cell.add(Box(size=(0.02, 0.02, 0.03)), spatial.pose((0, 0, 0.045)), name="post", free=False)
    for name, middle in (("paper", 0.022), ("roof", 0.068)):  # below and over what is placed
        cell.add(Box(size=(1.0, 1.0, 0.004)), spatial.pose((0, 0, middle)), name=name, free=False)
    apart = np.array(size) / 2 + 0.01 + 0.02
    expected = [tuple(offset) for offset in empty if (np.abs(offset) >= apart).any()]
    assert [tuple(offset) for offset in support.free_offsets(cell, "bar")] == expected
    assert len(empty) == 49 and len(expected) == 46


def test_places_on_a_turned_support_are_along_its_own_axes():
    cell, turn = Cell(), 0.3
    place = spatial.pose((0.5, -0.2, 0.1), (np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)))
    cell.add(Box(size=(0.4, 0.6, 0.2)), place, name="tray", free=False)
    support = find_support(cell, "tray")
    assert support.half == pytest.approx([0.2, 0.3])
    for x, y in ((0.0, 0.0), (0.1, -0.25)):
        along = [x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)]
        expected = [0.5 + along[0], -0.2 + along[1], 0.2]
        assert support.at(np.array([x, y])) == pytest.approx(expected)


def test_the_top_of_a_tilted_board_is_over_its_middle_at_the_height_of_its_highest_corner():
    cell, place = Cell(), pin.SE3(pin.rpy.rpyToMatrix(2.5, 0.4, -1.1), np.array([0.4, -0.3, 1.2]))
    cell.add(Shelf(size=(0.2, 0.3, 0.4)), place, name="rack")
    board = cell.model.geom("rack/board_2").id
    turn, middle = cell.data.geom_xmat[board].reshape(3, 3), cell.data.geom_xpos[board]
    corners = np.array(list(product((-1, 1), repeat=3))) * cell.model.geom_size[board] @ turn.T
    support = find_support(cell, "rack/board_2")
    assert support.top == pytest.approx([*middle[:2], middle[2] + corners[:, 2].max()], abs=1e-6)
    assert support.half == pytest.approx([0.1, 0.135], abs=1e-6)


def test_destinations_are_boxes_in_the_frame_of_the_thing():
    cell, place = Cell(), pin.SE3(pin.utils.rotate("z", 0.7), np.array([0.5, -0.2, 0.1]))
    cell.add(Box(size=(0.4, 0.6, 0.2)), place, name="tray", free=False)
    corner = np.array([[0.2, 0.3, 0.1]])
    for found, lower, walls in (
        (Destination.inside(cell, "tray"), -corner, True),
        (Destination.on(cell, "tray"), corner * [-1, -1, 1], False),
    ):
        assert found.T_wd.isApprox(place, 1e-9) and found.walls is walls
        assert found.lower == pytest.approx(lower) and found.upper == pytest.approx(corner)


def test_boards_of_a_shelf_are_supports(with_the_cube, trial):
    cell = with_the_cube.cell
    shelf = Shelf(size=(0.2, 0.3, 0.2))
    cell.add(shelf, spatial.pose((0.45, -0.15, 1.015), (0.0, 0.0, 0.0, 1.0)), name="rack")
    with pytest.raises(CellError, match=r"'rack' has no geom 'bord_1'; did you mean 'rack/board_1"):
        find_support(cell, "rack/bord_1")
    placing = trial(PlaceOn(object="cube", support="rack/board_3"))
    placing.tick_until("SUCCESS", timeout=8.0)
    assert cell.pose("cube").translation[2] == pytest.approx(1.015 + 0.2 + 0.025, abs=2e-3)
    cell.move("cube", spatial.pose((0.45, -0.15, 1.04 + shelf.levels[0])))
    cell.step(100)
    reason = placing.behaviour.why_not_released("cube")
    assert reason == "'cube' is not at the height of 'rack/board_3'"


def test_place_at_puts_the_middle_of_the_bottom_straight_down_at_the_pose(with_the_cube, trial):
    target = spatial.pose((0.4, -0.1, 1.015), (np.cos(0.15), 0, 0, np.sin(0.15)))
    placing = trial(PlaceAt(object="cube", pose=target, height=0.13, gap=0.006))
    placing.tick_until(lambda: placing.behaviour.feedback_message == "lowering", timeout=5.0)
    over = with_the_cube.cell.pose("cube").translation
    assert over == pytest.approx([0.4, -0.1, 1.04 + 0.13 + 0.006], abs=2e-3)
    placing.tick_until(lambda: "opening" in placing.behaviour.feedback_message, timeout=5.0)
    assert with_the_cube.cell.pose("cube").translation[2] == pytest.approx(1.046, abs=2e-3)
    while placing.tick() is RUNNING and with_the_cube.gripper.width < 0.055:
        at = with_the_cube.cell.pose("cube").translation
        assert at[:2] == pytest.approx([0.4, -0.1], abs=1.5e-3)
    placing.tick_until("SUCCESS")
    assert with_the_cube.arm.payload is None and with_the_cube.gripper.is_free
    with_the_cube.cell.step(300)
    placed = with_the_cube.cell.pose("cube")
    assert placed.translation == pytest.approx([0.4, -0.1, 1.04], abs=2e-3)
    quarter = (yaw_of(placed) - 0.3) / (np.pi / 2)
    assert abs(quarter - round(quarter)) < 0.02


def test_an_object_that_does_not_stay_on_its_support_fails_the_placing(beside_another, trial):
    placing = trial(PlaceOn(object="cube", support="other"))
    placing.tick_until(lambda: "opening" in placing.behaviour.feedback_message, timeout=5.0)
    beside_another.cell.move("other", spatial.pose((0.2, -0.3, 1.04)))
    assert placing.fails_with("'cube' does not touch 'other'")
    assert beside_another.arm.payload is None


def test_an_object_that_comes_to_rest_elsewhere_fails_the_placing(with_the_cube, trial):
    placing = trial(PlaceAt(object="cube", pose=PLACE))
    placing.tick_until(lambda: with_the_cube.gripper.is_free, timeout=5.0)
    with_the_cube.cell.move("cube", spatial.pose((0.338, -0.15, 1.04)))
    assert placing.fails_with("'cube' came to rest 12 mm from its target")


def test_what_is_lost_on_the_way_is_told(with_the_cube, trial):
    placing = trial(PlaceAt(object="cube", pose=PLACE))
    placing.tick()
    with_the_cube.gripper.open()
    assert placing.fails_with("'cube' was lost during the motion")


def test_a_place_that_is_none_keeps_hold_and_fingers_that_cannot_let_go_are_told(
    with_the_cube, trial
):
    for placing, message in (
        (PlaceOn(object="cube", support="tabel"), "did you mean 'table'"),
        (PlaceOn(object="cube", support="cube"), "on itself"),
        (PlaceAt(object="cube", pose="3;0;1"), "unreachable"),
        (PlaceAt(object="cube", pose=PLACE, patience=0.01), "still touches cube after 0.01 s"),
    ):
        assert with_the_cube.gripper.held == ("cube",)
        assert trial(placing).fails_with(message, timeout=5.0)


def test_a_halted_placing_brakes_and_keeps_hold(with_the_cube, trial):
    placing = trial(PlaceAt(object="cube", pose=PLACE))
    for _ in range(60):
        assert placing.tick() is RUNNING
    placing.halt()
    with_the_cube.cell.step(500)
    assert not with_the_cube.arm.moving
    assert with_the_cube.gripper.held == ("cube",)


def test_reaching_for_an_enclosed_cube_fails_with_the_name_of_an_obstacle(station, trial):
    trial(Hover(object="cube", height=0.15)).tick_until("SUCCESS")
    T_wo = station.cell.pose("cube")
    for i, offset in enumerate([(0.07, 0, 0), (0, 0.07, 0), (-0.07, 0, 0), (0, -0.07, 0)]):
        station.cell.add(Cube(), T_wo * spatial.pose(offset), name=f"n{i}")
    station.cell.step()
    grips = top_grasp_poses(centre_pose(station.cell, "cube"), 0.025 - GRIP_DEPTH)
    _, largest = with_clearance(grips, GripperClearance(station.cell, station.robot, ["cube"]))
    assert largest.distance < 0.0
    assert trial(Reach(object="cube")).fails_with("leaves the gripper no clearance at 'cube'")
