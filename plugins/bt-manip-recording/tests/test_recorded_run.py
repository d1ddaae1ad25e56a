"""A recording tells what happened in its run, with the figures of its report."""

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


def test_intervals_of_nodes_and_contacts(make_run, tmp_path):
    root = Sequence(
        "root",
        SpawnObject(object="{cube}"),
        Fallback("rescue", AlwaysFailure("never"), Sleep("first", msec=30)),
        Parallel("both", Sleep("short", msec=20), Sleep("long", msec=60), success_count=1),
        Sleep("first", msec=20),  # another node of this name
    )
    make_run(root).execute([McapRecorder(tmp_path / "run.mcap")])
    run = RecordedRun(Recording(tmp_path / "run.mcap"))
    found = [
        (node.name, node.depth, node.is_leaf, *times(node.intervals)) for node in run.nodes.values()
    ]
    assert [one for one in found if one[0] != "SpawnObject"] == [
        ("root", 0, False, (0.0, 0.07, "SUCCESS")),
        ("rescue", 1, False, (0.0, 0.03, "SUCCESS")),
        ("never", 2, True, (0.0, 0.0, "FAILURE")),
        ("first", 2, True, (0.0, 0.03, "SUCCESS")),
        ("both", 1, False, (0.03, 0.05, "SUCCESS")),
        ("short", 2, True, (0.03, 0.05, "SUCCESS")),
        ("long", 2, True, (0.03, 0.05, "HALTED")),
        ("first", 1, True, (0.05, 0.07, "SUCCESS")),
    ]
    (touch,) = run.contacts["cube", "table"]
    assert touch.end == run.recording.end  # it lies there until the end


def test_a_cut_recording_has_an_open_cycle_and_running_nodes_and_a_tree_or_is_refused(
    picked, tmp_path
):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(picked.read_bytes()[: picked.stat().st_size // 2])
    run = RecordedRun(Recording(cut))
    assert not run.recording.complete
    assert run.cycles[-1].status == "RUNNING"
    assert run.cycles[-1].end == run.recording.end
    root = next(iter(run.nodes.values()))
    assert root.intervals[-1].status == "RUNNING"
    assert root.intervals[-1].end == run.recording.end
    cut.write_bytes(picked.read_bytes()[:500])
    with pytest.raises(BtManipError, match="is not the recording of a run"):
        RecordedRun(Recording(cut))


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
    for path in (picked, tmp_path / "export.mcap"):
        with path.open("rb") as file:
            records = list(StreamReader(file, emit_chunks=True, validate_crcs=True).records)
        (end,) = [record for record in records if isinstance(record, DataEnd)]
        assert end.data_section_crc  # 0 would mean none
