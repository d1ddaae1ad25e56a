"""Everything that the package brings keeps the contracts of its kind."""

from dataclasses import replace

import pytest

from bt_manip import build_station as build
from bt_manip import spatial
from bt_manip.behaviours import CloseGripper, Grasp, Hover, Lift, Reach, extent
from bt_manip.cell import is_in
from bt_manip.scenes import SceneObject
from bt_manip.testing import built_in_situations, play, run_tree, trees_of
from bt_manip_contracts import Example, contracts_of
from bt_manip_impedance import ReachHandle

OVER_THE_BUTTON = "over the button"
OVER_THE_HOLE = "the peg is held over the hole"
AT_THE_HANDLE = "the handle of the drawer is held"

test_contracts = contracts_of(
    "impedance",
    without=tuple(  # the runs of their trees go on from their states, too
        f"scene {name}: goes on from its state"
        for name in ("hand_over", "open_drawer", "peg_in_hole", "peg_on_table", "press_button")
    ),
    examples={
        "Press": Example(
            ports={"object": "button", "hold": 0.05, "speed": 0.3, "max_force": 80.0},
            start=OVER_THE_BUTTON,
            fails=({"object": "table"}, {"max_force": 0.5}, {"depth": -0.01}),
        ),
        "IsReleased": Example(ports={"object": "button"}, start=OVER_THE_BUTTON),
        "WasPressed": Example(ports={"object": "button"}, start=OVER_THE_BUTTON, status="FAILURE"),
        "IsInserted": Example(
            ports={"object": "peg", "socket": "board"}, start=OVER_THE_HOLE, status="FAILURE"
        ),
        "Insert": Example(
            ports={"object": "peg", "socket": "board", "speed": 0.3},
            start=OVER_THE_HOLE,
            fails=({"max_force": 0.1}, {"controller": "no_controller"}, {"search": -1.0}),
        ),
        "ReachHandle": Example(
            ports={"object": "drawer", "height": 0.06},
            fails=({"object": "table"}, {"height": -0.1}, {"height": 5.0}),
        ),
        "PullOpen": Example(
            ports={"object": "drawer", "opening": 0.03, "speed": 0.5},
            start=AT_THE_HANDLE,
            fails=({"object": "table"}, {"opening": 1.0}, {"max_force": 0.1}),
        ),
        "IsOpen": Example(ports={"object": "drawer"}, status="FAILURE"),
        "FindFreeEnd": Example(
            ports={"object": "peg", "pose": "{pose}"},
            start=OVER_THE_HOLE,
            fails=({"object": "table"}, {"inset": -1.0}),
        ),
        "HoldOut": Example(ports={"object": "peg", "receiver": "nobody"}, status="FAILURE"),
        "IsHandedOver": Example(
            ports={"object": "peg", "giver": "panda", "receiver": "panda"}, status="FAILURE"
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


def drawer_is_open(station):
    """Return whether the drawer is open by 15 cm, without the gripper."""
    assert station.cell.find("drawer").opening >= 0.15
    assert not station.cell.contacts.touching("drawer", "arm")


def rod_is_in_the_basket(station):
    """Return whether the rod lies in the basket of the robot that took it."""
    assert is_in(station.cell, "rod", "basket")


END_STATES = {
    "press_button": button_is_released,
    "insert_peg": peg_is_in_the_hole,
    "peg_in_hole": peg_is_in_the_hole,
    "open_drawer": drawer_is_open,
    "hand_over": rod_is_in_the_basket,
}

test_trees = trees_of("impedance", end_states=END_STATES)


@pytest.mark.soak
@pytest.mark.parametrize("tree", ["press_button", "peg_in_hole", "open_drawer", "hand_over"])
def test_two_hundred_of_two_hundred(tree, parts):
    run_tree(tree, parts, end_state=END_STATES[tree], cycles=200, seed=1)


@pytest.fixture(scope="session")
def build_station(parts):
    """Give every test here the compliant arm, the button, the peg with its board, and a drawer."""

    def build_compliant():
        scene = parts.scenes.create("button_on_table")
        peg_and_board = parts.scenes.create("peg_on_table").objects[1:]
        drawer = SceneObject(
            "drawer", "drawer", spatial.pose((0.6, 0.25, scene.T_wb.translation[2]))
        )
        scene = replace(scene, objects=(*scene.objects, *peg_and_board, drawer))
        return build(parts, controller="cartesian_impedance", scene=scene)

    return build_compliant


@pytest.fixture(scope="session")
def situations(build_station):
    """Add situations right over the button, over the hole and at the handle."""

    def hover(station):
        play(station, CloseGripper(force=10.0), Hover(object="button", height=0.04))

    found = built_in_situations(build_station)

    def hold_peg(station):
        play(station, Hover(object="peg", height=0.15), Reach(object="peg"))
        play(station, Grasp(object="peg", force=40.0), Lift(height=0.1))

    def hold_handle(station):
        play(station, ReachHandle(object="drawer"), CloseGripper(force=50.0))

    found.add(AT_THE_HANDLE, hold_handle)
    found.add(OVER_THE_BUTTON, hover)
    found.add(OVER_THE_HOLE, hold_peg)
    return found
