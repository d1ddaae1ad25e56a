"""Everything that the package brings keeps the contracts of its kind."""

import pytest

from bt_manip.behaviours import CloseGripper, Hover
from bt_manip.runner import build_station as build
from bt_manip.testing import Example, built_in_situations, contracts_of, play, trees_of

OVER_THE_BUTTON = "over the button"

test_contracts = contracts_of(
    "impedance",
    examples={
        "Press": Example(
            ports={"object": "button", "hold": 0.05, "speed": 0.3, "max_force": 80.0},
            start=OVER_THE_BUTTON,
            fails=({"object": "table"}, {"max_force": 0.5}),
        )
    },
)


def let_go(station):
    """Nobody presses the button any more."""
    assert station.cell.find("button").depth < 1e-4


test_trees = trees_of("impedance", end_states={"press_button": let_go})


@pytest.fixture(scope="session")
def build_station(parts):
    """Give every test here the compliant arm and the button."""

    def build_compliant():
        scene = parts.scenes.create("button_on_table")
        return build(parts, controller="cartesian_impedance", scene=scene)

    return build_compliant


@pytest.fixture(scope="session")
def situations(build_station):
    """Add a situation right over the button."""

    def hover(station):
        play(station, CloseGripper(force=10.0), Hover(object="button", height=0.06))

    found = built_in_situations(build_station)
    found.add(OVER_THE_BUTTON, hover)
    return found
