"""Tests of a tree disturb it by the marker ``fault``."""

import pytest

from bt_manip.bt import Sequence, Sleep


@pytest.mark.fault("heavy at=second mass=4")
def test_a_fault_of_the_marker_begins_at_its_node_and_ends_with_the_root(station, trial):
    running = trial(Sequence("all", Sleep("first", msec=30), Sleep("second", msec=30)))
    running.tick_until("RUNNING", node="second")
    assert not station.cell.overrides
    running.tick()
    assert station.cell.overrides == {"cube": {"mass": 4.0}}
    running.until_done()
    assert not station.cell.overrides


@pytest.mark.fault("push at=rest force=20")
@pytest.mark.fault("heavy at=rest mass=4")
def test_faults_end_when_the_tree_is_halted(station, trial):
    running = trial(Sleep("rest", msec=300))
    for _ in range(3):
        running.tick()
    assert station.cell.overrides and station.cell.data.xfrc_applied.any()
    running.halt()
    assert not station.cell.overrides and not station.cell.data.xfrc_applied.any()


@pytest.mark.fault("heavy at=rest after=1")
def test_a_fault_that_has_not_happened_fails_the_test(trial):
    running = trial(Sleep("rest", msec=30))
    with pytest.raises(AssertionError, match="'heavy at=rest after=1' did not happen in cycle 1"):
        running.until_done()
