"""All that the package brings keeps its contracts, and its trees do what they are for."""

import pytest

from bt_manip.testing import assert_stands_still, trees_of
from bt_manip_contracts import Example, contracts_of


def the_mug_stands_on_the_middle_board(station):
    cell = station.cell
    assert station.gripper.is_free
    assert_stands_still(cell, "mug")
    T_ws, T_wm = cell.pose("shelf"), cell.pose("mug")
    x, y, z = T_ws.actInv(T_wm.translation)
    width, depth, _ = cell.find("shelf").parameters["size"]
    assert abs(x) < width / 2 and abs(y) < depth / 2
    assert z == pytest.approx(cell.find("shelf").levels[1], abs=2e-3)
    assert T_wm.rotation[2, 2] > 0.999


def what_the_box_holds_stands_on_its_floor(station):
    cell = station.cell
    assert station.gripper.is_free
    inside = [name for name in cell.objects if cell.contacts.touching(name, "box")]
    assert inside and all(name.endswith("can") for name in inside)
    assert_stands_still(cell, *inside)


END_STATES = {
    "mug_on_shelf": the_mug_stands_on_the_middle_board,
    "cans_into_box": what_the_box_holds_stands_on_its_floor,
}

EXAMPLES = {
    "ReadSentence": Example(
        {"objects": "{o}", "task": "{t}"}, "two cans",
        fails=({"sentence": "put the blue can into the box"},),
    ),
    "HoldsExactly": Example(
        {"container": "box", "objects": "red_can"}, "a can in the box",
        fails=({"objects": "red_can;green_can"}, {"objects": "green_can"}, {"container": "x"}),
    ),
}  # fmt: skip

test_parts_keep_their_contracts = contracts_of("everyday", examples=EXAMPLES)

test_trees_end_as_they_should = trees_of("everyday", end_states=END_STATES, seed=1)
