"""Goals hold only where a person who looks at the cell would say so."""

import math

import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip import spatial
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell
from bt_manip.cell.objects import Box, Table
from bt_manip_impedance import HoleBoard, Peg
from bt_manip_impedance.insert import IsInserted
from bt_manip_impedance.press import WasPressed
from bt_manip_impedance.push_button import PushButton

TOP = 1.015  # [m] height of the table
LENGTH = 0.09  # [m] of the peg


@pytest.fixture
def inserted():
    """Return why a peg at a position in the frame of the turned board is not inserted."""
    cell = Cell()
    with cell.editing():
        cell.add(Table(), spatial.pose((0.0, 0.0, 0.0)))
        cell.add(HoleBoard(), spatial.pose((0.0, 0.0, TOP)), name="board")
        cell.add(Peg(), spatial.pose((0.0, 0.0, TOP + 0.1)), name="peg", overlap=1.0)
    condition = IsInserted("inserted", object="peg", socket="board")
    tree = Tree(condition)
    tree.setup(cell=cell)

    def inserted(yaw, x, y, z):
        T_wb = spatial.pose((0.0, 0.0, TOP), (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))
        cell.move("peg", T_wb * spatial.pose((x, y, z + 0.5)), overlap=1.0)
        cell.move("board", T_wb, overlap=1.0)
        cell.move("peg", T_wb * spatial.pose((x, y, z)), overlap=1.0)
        cell.step(500)
        return condition.feedback_message if tree.tick() is NodeStatus.FAILURE else ""

    return inserted


@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_a_peg_is_inserted_in_the_hole_and_not_beside_the_turned_board(inserted, yaw):
    assert not inserted(yaw, 0.0, 0.0, LENGTH / 2 + 0.001)
    for angle in np.arange(8) * math.pi / 4:
        edge = np.array([math.cos(angle), math.sin(angle)])
        x, y = 0.1 * edge / np.abs(edge).max()
        assert "not 30 mm deep in a hole" in inserted(yaw, x, y, LENGTH / 2 + 0.001)


def test_a_peg_on_the_board_is_not_inserted(inserted):
    assert "not 30 mm deep in a hole" in inserted(0.0, 0.05, 0.0, 0.04 + LENGTH / 2 + 0.001)


@pytest.mark.parametrize(("depth", "holds"), [(0.027, False), (0.031, True)])
def test_from_below_the_surrounded_length_counts(depth, holds):
    """The board lies on two posts, and the peg stands on a third one in its hole."""
    cell = Cell()
    with cell.editing():
        for name, x, height in (("left", -0.07, 0.2), ("right", 0.07, 0.2), ("post", 0.0, 0.11)):
            size = (0.01, 0.1, height + (depth if name == "post" else 0.0))
            T = spatial.pose((x, 0.0, 0.5 * size[2]))
            cell.add(Box(size=size), T, name=name, free=False)
        cell.add(HoleBoard(), spatial.pose((0.0, 0.0, 0.2)), name="board", free=False)
        cell.add(Peg(), spatial.pose((0.0, 0.0, 0.11 + depth + LENGTH / 2)), name="peg")
    cell.step(500)
    condition = IsInserted("inserted", object="peg", socket="board", depth=0.03)
    tree = Tree(condition)
    tree.setup(cell=cell)
    assert (tree.tick() is NodeStatus.SUCCESS) is holds


@pytest.mark.parametrize(
    ("x", "depth", "share"), [(0.0, 0.015, 0.5), (0.0, -0.02, 0.0), (0.1, 0.02, 0.0)]
)
def test_progress_is_the_share_of_the_depth_in_the_hole_and_none_beside_it(x, depth, share):
    cell, offset = Cell(), (0.02, -0.01)
    T_wb = spatial.pose((0.3, -0.2, 0.1), (math.cos(0.2), 0.0, 0.0, math.sin(0.2)))
    at = (x + offset[0], offset[1], 0.04 - depth + LENGTH / 2)  # the board is 40 mm high
    with cell.editing():
        cell.add(HoleBoard(offset=offset), T_wb, name="board", free=False)
        cell.add(Peg(), T_wb * spatial.pose(at), name="peg", free=False)
    condition = IsInserted("inserted", object="peg", socket="board", depth=0.03)
    Tree(condition).setup(cell=cell)
    assert condition.progress() == pytest.approx(share, abs=1e-6)


def test_a_goal_counts_presses_of_its_own_cycle_which_a_snapshot_keeps():
    cell = Cell()
    cell.add(PushButton(), spatial.pose((0.0, 0.0, 0.0)), name="button")
    condition = WasPressed("pressed", object="button", released=True)
    tree = Tree(condition)
    tree.setup(cell=cell, robots={})
    before = cell.snapshot()
    assert tree.tick() is NodeStatus.FAILURE
    cell.data.qpos[0] = 0.008
    cell.step(500)
    assert tree.tick() is NodeStatus.SUCCESS and cell.find("button").presses == 1
    after = cell.snapshot()
    for state, presses in ((before, 0), (after, 1)):
        cell.restore(state)
        assert cell.find("button").presses == presses
    condition.begin_cycle()
    cell.step(100)
    assert tree.tick() is NodeStatus.FAILURE
    cell.data.qpos[0] = 0.008
    cell.step(500)
    assert tree.tick() is NodeStatus.SUCCESS


class Corner(composer.Entity):
    """A socket whose frame is at a corner."""

    def _build(self):
        self.root = mjcf.RootElement(model="corner")
        self.root.worldbody.add("geom", type="box", size=(0.1, 0.2, 0.02), pos=(0.1, 0.2, 0.02))

    mjcf_model = property(lambda self: self.root)


def test_the_hole_is_in_the_middle_of_a_socket_whose_frame_is_at_its_corner():
    cell = Cell()
    cell.add(Corner(), spatial.pose((0.3, -0.4, 0.5)), name="board", free=False)
    condition = IsInserted("inserted", object="peg", socket="board", depth=0.03)
    condition.setup(cell=cell)
    (place,) = condition.places().values()
    assert 0.5 * (place.lower + place.upper)[0, :2] == pytest.approx([0.1, 0.2])
