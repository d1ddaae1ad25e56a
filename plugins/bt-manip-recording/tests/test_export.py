"""What is exported is what was recorded."""

import numpy as np
import pytest
from mcap.reader import make_reader
from pyarrow import csv, parquet

from bt_manip.exceptions import BtManipError
from bt_manip_recording import Recording, write_csv, write_mcap, write_parquet
from tests.support.recorded import recorded as recorded


@pytest.fixture(scope="module")
def table(recorded):
    recording, folder, _ = recorded
    write_parquet(recording, folder / "run.parquet")
    return parquet.read_table(folder / "run.parquet")


def test_the_table_has_the_recorded_control_steps_and_the_identity_of_the_run(recorded, table):
    recording, _, cube = recorded
    assert b'"tree": "test"' in table.schema.metadata[b"bt_manip"]
    steps = recording.control_steps()
    assert table.num_rows == len(cube.steps) > 200
    assert table["t"].to_pylist() == steps["t"].tolist()
    for i, joint in enumerate(recording.joints["panda"]):
        for name in ("q", "v", "q_ref", "v_ref", "a_ref", "tau"):
            assert table[f"panda/{joint}/{name}"].to_pylist() == steps[name][:, i].tolist()


def test_objects_have_a_pose_while_they_are_there(recorded, table):
    _, _, cube = recorded
    columns = [table[f"cube/{axis}"].to_pylist() for axis in "xyz"]
    ends = np.array([time for time, _ in cube.ticks])
    seen = 0
    for i in range(0, table.num_rows, 7):
        tick = np.searchsorted(ends, cube.steps[i][0] + 1e-9) - 1
        expected = cube.ticks[tick][1] if tick >= 0 else None
        found = [column[i] for column in columns]
        if expected is None:
            assert found == [None] * 3
        else:
            assert found == expected.tolist()
            seen += 1
    assert 0 < seen < table.num_rows / 7 - 5


def test_the_running_leaf_and_its_phase_are_those_of_the_tick(recorded, table):
    _, _, cube = recorded
    assert [path.split("/")[-1] for path in table["node"].to_pylist()] == [n for _, n in cube.steps]
    phases = table["phase"].to_pylist()
    assert "turn" in phases and set(phases) <= {"turn", "rest", "end", ""}


def test_the_state_of_the_gripper_is_that_after_the_last_tick(recorded, table):
    recording, _, _ = recorded
    states = [(t, state) for t, _, state in recording.messages("/robots/panda/state")]
    time, state = states[len(states) // 2]
    row = table.slice(table["t"].to_pylist().index(time), 1).to_pylist()[0]
    assert [row[f"panda/force_{axis}"] for axis in "xyz"] == state["force"]
    assert [row[f"panda/torque_{axis}"] for axis in "xyz"] == state["torque"]
    assert [row[f"panda/grip_force{i}"] for i in (1, 2)] == state["grip_forces"]
    assert row["panda/speed_scale"] == 1.0 and row["panda/held"] == ""
    assert table["panda/force_x"][0].as_py() is None  # before the end of the first tick


def test_a_csv_file_has_the_same_table(recorded, table):
    recording, folder, _ = recorded
    write_csv(recording, folder / "run.csv")
    options = csv.ConvertOptions(column_types=table.schema.remove_metadata())
    read = csv.read_csv(folder / "run.csv", convert_options=options)
    assert read.column_names == table.column_names
    for name in table.column_names:
        assert read[name].to_pylist() == table[name].to_pylist()


def test_a_recording_without_control_steps_has_no_table(recorded, tmp_path):
    recording, _, _ = recorded
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.path.read_bytes()[:2000])
    with pytest.raises(BtManipError, match=r"cut.mcap has no control steps"):
        write_parquet(Recording(cut), tmp_path / "cut.parquet")
    assert [path.name for path in tmp_path.iterdir()] == ["cut.mcap"]


def test_a_cut_recording_becomes_a_complete_one(recorded, tmp_path):
    recording, _, _ = recorded
    cut, complete = tmp_path / "cut.mcap", tmp_path / "complete.mcap"
    with recording.path.open("rb") as file:
        last = make_reader(file).get_summary().chunk_indexes[-1]
    end = last.chunk_start_offset + last.chunk_length
    cut.write_bytes(recording.path.read_bytes()[: end + 100])
    whole = Recording(cut)
    assert not whole.complete
    write_mcap(whole, complete)
    assert Recording(complete).complete and Recording(complete).identity == recording.identity
    with complete.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None and summary.chunk_indexes  # not by scanning
        found = [
            (m.sequence, m.log_time / 1e9, channel.topic, m.data)
            for _, channel, m in reader.iter_messages()
        ]
        assert {schema.name for schema in summary.schemas.values()} >= {"foxglove.SceneUpdate"}
    raw = [(s, t, topic) for s, t, topic, _ in whole.numbered_messages()]
    assert sorted(row[:3] for row in found) == sorted(raw) and len(raw) > 500
    expected = [data for _, _, data in whole.messages("/tf")]
    assert [data for *_, topic, data in found if topic == "/tf"] == expected
    write_mcap(whole, cut)  # in its place
    assert Recording(cut).complete and Recording(cut).end == whole.end
