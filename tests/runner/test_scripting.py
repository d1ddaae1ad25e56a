"""A station steps until something has happened, and runs a tree to its end."""

import pytest

from bt_manip.behaviours import ObjectExists
from bt_manip.bt import NodeStatus, Precondition, Sequence, Sleep, Tree
from tests.support.notebook import built as built
from tests.support.notebook import station as station


def test_it_steps_until_the_condition_holds_or_the_timeout_and_no_further(station):
    start = station.cell.time
    station.step_until(lambda: station.cell.time > start + 0.0495)
    assert station.cell.time == pytest.approx(start + 0.050)
    before = station.cell.state_bytes()
    station.step_until(lambda: True)
    assert station.cell.state_bytes() == before
    start = station.cell.time
    with pytest.raises(TimeoutError, match="within 0.02 s"):
        station.step_until(lambda: False, timeout=0.02)
    assert station.cell.time == pytest.approx(start + 0.020)


def test_a_tree_runs_to_its_end_by_simulated_time_in_ticks_of_the_length_asked_for(station):
    for tick, duration in ((0.010, 0.040), (0.020, 0.040), (0.030, 0.060)):
        start = station.cell.time
        rest = Tree(Sequence("wait", Sleep("rest", msec=40)), clock=station.clock)
        assert station.run(rest, tick=tick).status is NodeStatus.SUCCESS
        assert station.cell.time == pytest.approx(start + duration)


def test_a_result_says_how_a_tree_ended_and_why(station):
    assert str(station.run(ObjectExists(object="table"))) == "SUCCESS"
    failed = station.run(Sequence("all", ObjectExists("check", object="tabel")))
    assert failed.reason in str(failed) and str(failed).startswith("FAILURE: ")
    assert "check" in failed.reason and "tabel" in failed.reason


def test_cells_and_stations_show_what_they_are(station):
    name = f"Cell({station.cell.time:.3f} s; table, basket, panda)"
    assert repr(station.cell) == name
    assert repr(station) == f"Station(robots: panda; {name})"


def test_a_tree_with_nothing_to_do_is_skipped(station):
    root = Precondition("never", ObjectExists(object="table"), **{"if": "false", "else": "SKIPPED"})
    assert station.run(root).status is NodeStatus.SKIPPED


def test_a_tree_that_takes_too_long_is_halted(station):
    tree = Tree(Sleep("long nap", msec=10_000), clock=station.clock)
    with pytest.raises(TimeoutError, match="after 0.05 s the tree is still at 'long nap'"):
        station.run(tree, timeout=0.05)
    assert tree.statuses() == bytes([NodeStatus.IDLE])
