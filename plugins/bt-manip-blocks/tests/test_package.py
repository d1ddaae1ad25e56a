"""All that the package brings keeps its contracts, and its trees do what they are for."""

import numpy as np
import pytest

from bt_manip.runner import Station
from bt_manip.testing import (
    assert_stands_still,
    assert_touches_only,
    assert_tower,
    run_tree,
    trees_of,
)
from bt_manip_blocks import ColouredBlock
from bt_manip_contracts import Example, contracts_of


def blocks_of(station: Station) -> dict[str, ColouredBlock]:
    objects = station.cell.objects
    return {name: block for name, block in objects.items() if isinstance(block, ColouredBlock)}


def a_tower_of_four_stands(station: Station) -> None:
    """Four blocks on one another, a second later too, and the hand is away from them."""
    cell = station.cell
    assert station.gripper.is_free
    for _ in range(2):
        tower = sorted(blocks_of(station), key=lambda name: cell.pose(name).translation[2])
        assert len(tower) == 4
        assert_tower(cell, tower, on="table")
        base = cell.pose(tower[0]).translation
        for name in tower[1:]:
            off = float(np.linalg.norm((cell.pose(name).translation - base)[:2]))
            assert off < 4e-3, f"'{name}' is {1000 * off:.1f} mm beside the base"
        cell.step(1000)


def every_block_is_in_its_row(station: Station) -> None:
    """Nine blocks stand still on the tray, each in the row of its colour, none on another."""
    cell = station.cell
    assert station.gripper.is_free
    tray = cell.find("tray")
    blocks = blocks_of(station)
    assert sorted(block.colour for block in blocks.values()) == sorted(["red", "green", "blue"] * 3)
    for _ in range(2):
        assert_stands_still(cell, *blocks)
        for name, block in blocks.items():
            assert_touches_only(cell, name, "tray")
            place = cell.pose("tray").actInv(cell.pose(name).translation)
            assert tray.row_at(place) == block.colour, f"'{name}' is over {tray.row_at(place)}"
        cell.step(1000)


END_STATES = {"stack_blocks": a_tower_of_four_stands, "sort_blocks": every_block_is_in_its_row}

EXAMPLES = {
    "ScatterBlocks": Example(
        {"blocks": "{blocks}"},
        fails=(
            {"spacing": 0.5, "each": 3}, {"region": "1;0;0;1"}, {"colours": "rde"}, {"on": "x"},
        ),
    ),
    "ChooseBlock": Example({"block": "{block}"}, "two blocks", fails=({"on": "tray"},)),
    "ChooseBase": Example({"base": "{base}"}, "two blocks", fails=({"on": "tray"},)),
    "AreSorted": Example(start="two blocks", status="FAILURE"),
    "AreStacked": Example(start="one block", fails=({"on": "tray"},)),
    "FindSlot": Example({"block": "red", "pose": "{pose}"}, "two blocks", fails=({"tray": "red"},)),
}  # fmt: skip

test_parts_keep_their_contracts = contracts_of("blocks", examples=EXAMPLES)

test_trees_end_as_they_should = trees_of("blocks", end_states=END_STATES, seed=1)


@pytest.mark.soak
@pytest.mark.parametrize("tree", END_STATES)
def test_two_hundred_of_two_hundred(tree, parts):
    run_tree(tree, parts, end_state=END_STATES[tree], cycles=200)
