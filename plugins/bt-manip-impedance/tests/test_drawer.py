"""A drawer slides out of its cabinet against friction."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell, CellError
from bt_manip_impedance import Drawer
from bt_manip_impedance.drawer import SIZE

TRAVEL, RESISTANCE = 0.2, 5.0


def pulled(force: float, steps: int = 600) -> Drawer:
    cell = Cell()
    cell.add(Drawer(travel=TRAVEL, resistance=RESISTANCE), pin.SE3(np.eye(3), np.zeros(3)))
    drawer = cell.find("drawer")
    assert isinstance(drawer, Drawer)
    cell.data.qfrc_applied[cell.model.joint("drawer/slide").dofadr[0]] = force
    cell.step(steps)
    return drawer


def test_friction_keeps_a_drawer_closed():
    assert pulled(0.8 * RESISTANCE).opening == pytest.approx(0.0, abs=2e-4)


def test_a_larger_force_opens_a_drawer_to_its_stop():
    assert 0.02 < pulled(2.0 * RESISTANCE, 200).opening < TRAVEL
    assert pulled(6.0 * RESISTANCE, 2000).opening == pytest.approx(TRAVEL, abs=5e-3)


def test_the_handle_moves_with_the_drawer():
    closed, open_ = pulled(0.0), pulled(4.0 * RESISTANCE)
    moved = open_.T_oh.translation - closed.T_oh.translation
    assert moved == pytest.approx([closed.opening - open_.opening, 0.0, 0.0])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [({"travel": 0.0}, "travel"), ({"travel": 0.3}, "travel"), ({"resistance": 0.0}, "resistance")],
)
def test_impossible_parameters_are_refused(parameters, message):
    with pytest.raises(CellError, match=message):
        Drawer(**parameters)


def test_a_closed_drawer_is_a_box_of_its_size_and_the_same_on_both_sides():
    cell = Cell()
    cell.add(Drawer(), pin.SE3(np.eye(3), np.zeros(3)))
    cabinet = cell.model.geom_bodyid == cell.model.body("drawer/cabinet").id
    half = cell.model.geom_size[cabinet]
    lower, upper = cell.data.geom_xpos[cabinet] - half, cell.data.geom_xpos[cabinet] + half
    assert upper.max(axis=0) - lower.min(axis=0) == pytest.approx(SIZE)
    boxes = np.column_stack((cell.data.geom_xpos, cell.model.geom_size)).round(9) + 0.0
    mirrored = boxes * (1, -1, 1, 1, 1, 1) + 0.0
    assert {*map(tuple, boxes)} == {*map(tuple, mirrored)}
