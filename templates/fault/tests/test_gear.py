"""The fault is undone at its end, and disturbs a run."""

import pytest
from bt_manip.bt import Sleep
from bt_manip_contracts import contracts_of

test_contracts = contracts_of("gear")


@pytest.mark.fault("gear at=rest force=2.0")
def test_the_wind_moves_the_object(trial, cell):
    before = cell.pose("cube").translation[0]
    trial(Sleep("rest", msec=500)).tick_until("SUCCESS", timeout=1.0)
    assert cell.pose("cube").translation[0] > before + 0.05
