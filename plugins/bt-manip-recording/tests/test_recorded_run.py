"""A recording tells what happened in its run, with the figures of its report."""

import json

import pytest
from mcap.reader import make_reader
from mcap.records import DataEnd
from mcap.stream_reader import MAGIC_SIZE, StreamReader

from bt_manip.behaviours import SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Parallel, Sequence, Sleep
from bt_manip.exceptions import BtManipError
from bt_manip_recording import McapRecorder, RecordedRun, Recording, write_mcap
from bt_manip_recording.recorded_run import RecordedRobot


def times(intervals):
    return [(round(one.start, 6), round(one.end, 6), one.status) for one in intervals]


def test_cycles_have_the_figures_of_the_report(picked):
    run = RecordedRun(Recording(picked))
    reported = json.loads(picked.with_suffix(".json").read_text())["cycles"]
    assert len(run.cycles) == len(reported) == 2
    for cycle, expected in zip(run.cycles, reported, strict=True):
        assert (cycle.status, cycle.reason) == (expected["status"], expected["reason"])
        assert round(cycle.end - cycle.start, 6) == expected["duration_s"]
        assert cycle.max_tracking_error_rad == expected["max_tracking_error_rad"]
        assert vars(cycle.limits) == expected["limits"]


def test_the_first_tick_and_the_first_step_count(picked, monkeypatch):
    recording, topic = Recording(picked), "/robots/panda/state"
    messages = recording.messages
    state = {"grip_forces": [5], "gripped": ["cube"], "saturated_steps": 3, "speed_scale": 1.0}
    monkeypatch.setattr(
        recording, "messages", lambda name: [(0.0, 0, state)] if name == topic else messages(name)
    )
    robot = RecordedRobot(recording, "panda")
    robot.feed_ticks(0.0)
    cycle = robot.figures.cycle(0.0, lambda time: "")
    assert (cycle.picked, cycle.saturated_steps) == (("cube",), 3)
    robot.feed_steps(recording.end)
    assert len(robot.t) > 1 and robot.error[0].any() and robot.use[0].any()


def test_nodes_run_when_the_phases_of_the_report_say(picked):
    run = RecordedRun(Recording(picked))
    phases = json.loads(picked.with_suffix(".json").read_text())["cycles"][0]["phases"]
    for phase in phases:
        node = next(n for n in run.nodes.values() if n.name == phase["name"])
        first, duration = node.intervals[0], phase["duration_s"]
        assert round(first.start - run.cycles[0].start, 6) == phase["start_s"]
        assert round(first.end - first.start, 6) == duration
        assert first.status == phase["status"]


def test_intervals_of_nodes_and_contacts(make_run, tmp_path):
    root = Sequence(
        "root",
        SpawnObject(object="{cube}"),
        Fallback("rescue", AlwaysFailure("never"), Sleep("first", msec=30)),
        Parallel("both", Sleep("short", msec=20), Sleep("long", msec=60), success_count=1),
    )
    make_run(root).execute([McapRecorder(tmp_path / "run.mcap")])
    run = RecordedRun(Recording(tmp_path / "run.mcap"))
    found = {node.name: times(node.intervals) for node in run.nodes.values()}
    assert found["never"] == [(0.0, 0.0, "FAILURE")]
    assert found["first"] == [(0.0, 0.03, "SUCCESS")]
    assert found["short"] == [(0.03, 0.05, "SUCCESS")]
    assert found["long"] == [(0.03, 0.05, "HALTED")]
    assert found["root"] == [(0.0, 0.05, "SUCCESS")]
    depths = {node.name: (node.depth, node.is_leaf) for node in run.nodes.values()}
    assert depths["root"] == (0, False) and depths["rescue"] == (1, False)
    assert depths["first"] == (2, True)
    (touch,) = run.contacts["cube", "table"]
    assert touch.end == run.recording.end  # it lies there until the end


def test_a_cut_recording_has_an_open_cycle_and_running_nodes(picked, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(picked.read_bytes()[: picked.stat().st_size // 2])
    run = RecordedRun(Recording(cut))
    assert not run.recording.complete
    assert run.cycles[-1].status == "RUNNING"
    assert run.cycles[-1].end == run.recording.end
    root = next(iter(run.nodes.values()))
    assert root.intervals[-1].status == "RUNNING"
    assert root.intervals[-1].end == run.recording.end


def test_nodes_of_the_same_name_are_kept_apart(make_run, tmp_path):
    root = Sequence("root", Sleep("rest", msec=20), Sleep("rest", msec=40))
    make_run(root).execute([McapRecorder(tmp_path / "run.mcap")])
    run = RecordedRun(Recording(tmp_path / "run.mcap"))
    found = [times(node.intervals) for node in run.nodes.values() if node.name == "rest"]
    assert found == [[(0.0, 0.02, "SUCCESS")], [(0.02, 0.06, "SUCCESS")]]


def test_a_file_without_a_tree_is_refused(picked, tmp_path):
    start = tmp_path / "start.mcap"
    start.write_bytes(picked.read_bytes()[:500])
    with pytest.raises(BtManipError, match="is not the recording of a run"):
        RecordedRun(Recording(start))


def test_a_recording_with_a_damaged_byte_is_refused_wherever_it_is(picked, tmp_path):
    data, damaged = picked.read_bytes(), tmp_path / "damaged.mcap"
    with picked.open("rb") as file:
        end = make_reader(file).get_summary().chunk_indexes[-1]
    written = end.chunk_start_offset + end.chunk_length + end.message_index_length
    in_index = end.chunk_start_offset + end.chunk_length + 20  # its content is not read
    for offset in [in_index, *range(MAGIC_SIZE, written, written // 15)]:
        damaged.write_bytes(data[:offset] + bytes([data[offset] ^ 0xFF]) + data[offset + 1 :])
        with pytest.raises(BtManipError, match="damaged.mcap is damaged"):
            Recording(damaged)


def test_a_recording_and_its_export_have_the_checksum_that_the_library_computes(picked, tmp_path):
    write_mcap(Recording(picked), tmp_path / "export.mcap")
    check_checksum(picked)
    check_checksum(tmp_path / "export.mcap")


def check_checksum(path):
    with path.open("rb") as file:
        records = list(StreamReader(file, emit_chunks=True, validate_crcs=True).records)
    (end,) = [record for record in records if isinstance(record, DataEnd)]
    assert end.data_section_crc  # 0 would mean none
