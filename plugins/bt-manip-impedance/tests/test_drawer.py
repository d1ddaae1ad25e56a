"""A drawer slides out of its cabinet against friction."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell, CellError
from bt_manip_impedance import Drawer

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
