"""A button is a preloaded spring with a stop."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell, CellError
from bt_manip_impedance import PushButton

TRAVEL, FORCE = 0.008, 10.0


@pytest.fixture
def cell() -> Cell:
    cell = Cell()
    cell.add(PushButton(travel=TRAVEL, force=FORCE), pin.SE3(np.eye(3), np.zeros(3)))
    return cell


def press(cell: Cell, force: float) -> PushButton:
    joint = cell.model.joint("push_button/press")
    cell.data.qfrc_applied[joint.dofadr[0]] = force
    cell.step(300)
    button = cell.entities["push_button"]
    assert isinstance(button, PushButton)
    return button


def test_a_button_that_is_not_pressed_is_up(cell):
    button = press(cell, 0.0)
    assert button.depth == pytest.approx(0.0, abs=1e-4)
    assert not button.pressed


def test_the_cap_does_not_move_below_the_preload(cell):
    assert press(cell, 0.15 * FORCE).depth == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(("force", "depth"), [(4.0, 0.002), (6.0, 0.004), (8.0, 0.006)])
def test_above_the_preload_the_depth_is_proportional_to_the_force(cell, force, depth):
    # A fifth of the force lifts it off the stop; the rest is spread over the travel.
    assert press(cell, force).depth == pytest.approx(depth, abs=1e-4)


def test_it_is_pressed_below_half_of_its_travel(cell):
    assert not press(cell, 5.5).pressed
    assert press(cell, 6.5).pressed


def test_it_ends_at_its_travel(cell):
    assert press(cell, 1.2 * FORCE).depth == pytest.approx(TRAVEL, abs=1e-4)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [({"travel": 0.0}, "travel must be"), ({"force": -1.0}, "force must be")],
)
def test_impossible_parameters_are_refused(parameters, message):
    with pytest.raises(CellError, match=message):
        PushButton(**parameters)


def test_a_released_cap_is_as_high_as_the_button_says_and_sinks_into_the_housing(cell):
    button = cell.entities["push_button"]
    cap = cell.model.geom("push_button/cap").id
    height, half = cell.data.geom_xpos[cap][2], cell.model.geom_size[cap][1]
    assert height + half == pytest.approx(button.height)
    assert height - half <= button.height - TRAVEL
