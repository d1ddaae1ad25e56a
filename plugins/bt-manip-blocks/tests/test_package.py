"""All that the package brings keeps its contracts, and its trees do what they are for."""

import pytest

from bt_manip.testing import run_tree, trees_of
from bt_manip_contracts import Example, contracts_of

from .end_states import a_tower_of_four_stands, every_block_is_in_its_row

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
