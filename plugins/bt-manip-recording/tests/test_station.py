"""Scripts and notebooks record trees in their stations."""

import pytest

from bt_manip import build_station
from bt_manip.bt import NodeStatus, Sleep, Tree
from bt_manip.scenes import table_and_basket
from bt_manip_recording import Recording
from tests.support.notebook import built as built
from tests.support.notebook import station as station
from tests.support.notebook import visit, words


def test_a_station_records_a_tree_which_runs_as_without_a_recording(station, built, tmp_path):
    plain = station.run(visit())
    state = station.cell.state_bytes()
    station.set_state(built[1])
    result = station.run(visit(), record=tmp_path / "run.mcap")
    assert result.status is plain.status is NodeStatus.SUCCESS
    assert station.cell.state_bytes() == state
    assert str(result.recording) in result._repr_html_()
    recording = Recording(tmp_path / "run.mcap")
    assert recording.complete and recording.end == pytest.approx(result.duration)
    objects = [
        (e.data["name"], e.data["present"]) for e in recording.events() if e.kind == "entity"
    ]
    assert objects[-2:] == [("cube", True), ("cube", False)]
    statuses = [e.data for e in recording.events() if e.kind == "status"]
    assert [d["status"] for d in statuses if d["path"] == "visit"] == ["RUNNING", "SUCCESS", "IDLE"]
    assert words(recording._repr_html_()).startswith("Recording run.mcap tree visit robot panda")


def test_a_recording_is_closed_when_a_tree_takes_too_long(station, tmp_path):
    with pytest.raises(TimeoutError):
        station.run(Sleep("rest", msec=100), timeout=0.02, record=str(tmp_path / "run.mcap"))
    assert Recording(tmp_path / "run.mcap").complete


def test_a_recording_says_which_station_and_tree_it_is_of(parts, tmp_path):
    station = build_station(parts, scene="two_arms", seed=1)
    tree = Tree(Sleep("rest", msec=20), tree_id="Rest")
    result = station.run(tree, record=tmp_path / "run.mcap")
    identity = Recording(result.recording).identity
    assert (identity["seed"], identity["scene"], identity["tree"]) == (1, "two_arms", "Rest")
    built = build_station(parts, scene=table_and_basket())
    result = built.run(Sleep("rest", msec=20), record=tmp_path / "other.mcap")
    assert Recording(result.recording).identity["scene"] == "table_and_basket"
