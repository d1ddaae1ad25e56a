"""Pegs and boards have the sizes that they say, and fit or not."""

import pytest

from bt_manip.cell import Cell, extent
from bt_manip.spatial import pose
from bt_manip_impedance import HoleBoard, Peg


def test_a_peg_falls_through_a_hole_that_is_wider_and_stays_on_one_that_is_not():
    for hole, falls in ((0.0165, True), (0.013, False)):
        cell, peg = Cell(), Peg(radius=0.015)
        cell.add(HoleBoard(hole=hole), pose((0, 0, 0.5)))
        cell.add(peg, pose((0, 0, 0.54 + peg.rest_height + 1e-3)))
        cell.step(400)
        assert (cell.pose("peg").translation[2] < 0.4) == falls


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
