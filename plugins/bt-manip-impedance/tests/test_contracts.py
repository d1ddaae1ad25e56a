"""Everything that the package brings keeps the contracts of its kind."""

from dataclasses import replace

import pytest

from bt_manip.behaviours import CloseGripper, Grasp, Hover, Lift, Reach, extent
from bt_manip.runner import build_station as build
from bt_manip.testing import Example, built_in_situations, contracts_of, play, trees_of

OVER_THE_BUTTON = "over the button"
OVER_THE_HOLE = "the peg is held over the hole"

test_contracts = contracts_of(
    "impedance",
    examples={
        "Press": Example(
            ports={"object": "button", "hold": 0.05, "speed": 0.3, "max_force": 80.0},
            start=OVER_THE_BUTTON,
            fails=({"object": "table"}, {"max_force": 0.5}),
        ),
        "IsReleased": Example(ports={"object": "button"}, start=OVER_THE_BUTTON),
        "IsInserted": Example(
            ports={"object": "peg", "socket": "board"}, start=OVER_THE_HOLE, status="FAILURE"
        ),
        "Insert": Example(
            ports={"object": "peg", "socket": "board", "speed": 0.3},
            start=OVER_THE_HOLE,
            fails=({"max_force": 0.1}, {"controller": "no_controller"}),
        ),
    },
)


def button_is_released(station):
    """Return whether nothing presses the button."""
    assert station.cell.find("button").depth < 1e-4


def peg_is_in_the_hole(station):
    """Return whether the peg stands in the board."""
    bottom, top = extent(station.cell, "peg")[0], extent(station.cell, "board")[1]
    assert bottom[2] < top[2] - 0.02


test_trees = trees_of(
    "impedance",
    end_states={"press_button": button_is_released, "insert_peg": peg_is_in_the_hole},
)


@pytest.fixture(scope="session")
def build_station(parts):
    """Give every test here the compliant arm, the button, and the peg with its board."""

    def build_compliant():
        scene = parts.scenes.create("button_on_table")
        peg_and_board = parts.scenes.create("peg_on_table").fixtures[1:]
        scene = replace(scene, fixtures=(*scene.fixtures, *peg_and_board))
        return build(parts, controller="cartesian_impedance", scene=scene)

    return build_compliant


@pytest.fixture(scope="session")
def situations(build_station):
    """Add situations right over the button and over the hole."""

    def hover(station):
        play(station, CloseGripper(force=10.0), Hover(object="button", height=0.06))

    found = built_in_situations(build_station)

    def hold_peg(station):
        play(station, Hover(object="peg", height=0.15), Reach(object="peg"))
        play(station, Grasp(object="peg", force=40.0), Lift(height=0.1))

    found.add(OVER_THE_BUTTON, hover)
    found.add(OVER_THE_HOLE, hold_peg)
    return found
