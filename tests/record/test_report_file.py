"""A report's file holds every cycle that has ended, whatever happens to the process or the disk."""

import json
import math
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.record.files import FileInUseError, RecordingError
from bt_manip.record.report import report_file
from bt_manip.record.report.report_file import ReportFile, open_report_file, read_report
from bt_manip.record.report.run_report import (
    CycleLimitUse,
    CycleReport,
    LeafTime,
    LeafUse,
    Phase,
    RobotCycle,
    RunReport,
    versions,
)

PHASE = Phase("Grasp", "grasp it", "FAILURE", "the fingers met", 1.5, 0.25)
CYCLE = CycleReport(
    "SUCCESS",
    duration_s=1.75,
    phases=(PHASE,),
    limits=CycleLimitUse(0.5, 0.6, 0.7, 0.8, 0.9),
    unexpected_contacts=(("panda/hand", "table"),),
    randomized={"mass": {"cube": {"kg": 0.1}}},
    robots={"left": RobotCycle(("cube",), 10.0)},
)
FORMATS = pytest.mark.parametrize("name", ["report.json", "report.jsonl"])


def report(cycles: int, status: str = "RUNNING") -> RunReport:
    """Make a report in which each cycle has the reason that its number is."""
    each = tuple(replace(CYCLE, reason=f"number {i + 1}") for i in range(cycles))
    return RunReport("pick_place", 7, status, each, 1.75 * cycles, robot="panda", tick_s=0.01)


@pytest.fixture
def opened(tmp_path) -> Callable[[str], ReportFile]:
    """Open a file; its warnings are in `opened.warnings`."""

    def open_one(name: str) -> ReportFile:
        return open_report_file(tmp_path / name, open_one.warnings.append)

    open_one.warnings = []
    return open_one


@FORMATS
def test_what_was_written_is_read_also_while_the_run_goes_on(opened, tmp_path, name):
    file = opened(name)
    file.update(report(2))
    assert read_report(tmp_path / name) == report(2)
    file.close(report(3, "SUCCESS"))
    assert read_report(tmp_path / name) == report(3, "SUCCESS")
    assert [path.name for path in tmp_path.iterdir()] == [name]


@FORMATS
def test_a_report_that_nobody_writes_any_more_ended_without_an_end(opened, tmp_path, name):
    file = opened(name)
    file.update(report(2))
    (tmp_path / "copy").mkdir()
    left = tmp_path / "copy" / name
    left.write_bytes((tmp_path / name).read_bytes())
    assert read_report(left) == replace(report(2), status="ERROR", error=report_file.NO_END)
    file.close(report(2, "SUCCESS"))
    assert read_report(tmp_path / name) == report(2, "SUCCESS")


def test_json_in_pieces_is_the_json_of_the_whole(opened, tmp_path):
    file = opened("report.json")
    file.update(report(2))
    file.close(report(5, "SUCCESS"))
    assert (tmp_path / "report.json").read_text() == report(5, "SUCCESS").to_json()


def test_json_lines_have_a_type_each_and_hold_a_cycle_at_once(opened, tmp_path):
    file, path = opened("report.jsonl"), tmp_path / "report.jsonl"
    for cycles in range(3):
        file.update(report(cycles))
        assert len(read_report(path).cycles) == cycles
    file.close(report(2, "SUCCESS"))
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert [line["type"] for line in lines] == ["run", "cycle", "cycle", "end"]
    assert lines[0]["robot"] == "panda"
    assert lines[-1]["status"] == "SUCCESS"


def test_json_is_rewritten_once_a_period_also_if_the_run_hangs(opened, tmp_path, monkeypatch):
    monkeypatch.setattr(report_file, "PERIOD", 0.1)
    file, versions = opened("report.json"), set()
    start = time.monotonic()
    for cycles in range(60):
        file.update(report(cycles))
        time.sleep(0.005)
        versions.add((tmp_path / "report.json").stat().st_mtime_ns)
    elapsed = time.monotonic() - start
    assert 2 <= len(versions) <= elapsed / 0.1 + 1
    time.sleep(0.2)
    assert len(read_report(tmp_path / "report.json").cycles) == 59


def test_a_pipe_takes_one_json_object(opened, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    file = opened("pipe")
    file.update(report(1))
    file.close(report(2))
    assert len(json.loads(os.read(reader, 65536))["cycles"]) == 2
    os.close(reader)


@FORMATS
def test_a_full_disk_costs_only_the_cycles_after_it(
    opened, tmp_path, file_size_limit, monkeypatch, name
):
    monkeypatch.setattr(report_file, "PERIOD", 0.0)
    monkeypatch.setattr(report_file, "SHARE", math.inf)
    file, path = opened(name), tmp_path / name
    file_size_limit(10_000)
    for cycles in range(40):
        file.update(report(cycles))
    kept = len(read_report(path).cycles)
    assert 3 < kept < 30
    assert read_report(path) == report(kept)
    lost = f"report '{path}' cannot be written: File too large; cycle {kept + 1} is the first"
    with pytest.raises(RecordingError, match=lost):
        file.close(report(40, "SUCCESS"))
    assert read_report(path) == report(kept)
    (warning,) = opened.warnings
    assert lost in warning


@FORMATS
def test_nothing_is_lost_where_there_is_space_again(opened, tmp_path, file_size_limit, name):
    file = opened(name)
    file_size_limit(3000)
    for cycles in range(10):
        file.update(report(cycles))
    file_size_limit(1_000_000)
    file.close(report(10, "SUCCESS"))
    assert read_report(tmp_path / name) == report(10, "SUCCESS")


@pytest.mark.parametrize("name", ["device", "device.jsonl"])
def test_a_full_device_is_named_and_a_device_is_not_read(opened, tmp_path, name):
    (tmp_path / name).symlink_to("/dev/full")
    with pytest.raises(RecordingError, match=f"{name}' cannot be written: No space left"):
        opened(name).close(report(2))
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to("/dev/zero")
    with pytest.raises(BtManipError, match=f"{name}' cannot be read"):
        read_report(tmp_path / name)


def test_a_file_that_was_deleted_is_an_error(opened, tmp_path):
    file = opened("report.jsonl")
    file.update(report(1))
    (tmp_path / "report.jsonl").unlink()
    with pytest.raises(RecordingError, match="it was deleted; cycle 1 is the first that is lost"):
        file.close(report(1))


@pytest.mark.parametrize("cut", [1, 10, 200])
def test_an_unfinished_last_line_is_left_out(opened, tmp_path, cut):
    path = tmp_path / "report.jsonl"
    opened("report.jsonl").update(report(2))
    path.write_bytes(path.read_bytes()[:-cut])
    ended = replace(report(1), status="ERROR", error=report_file.NO_END)
    assert read_report(path) == ended


@FORMATS
def test_numbers_that_are_not_finite_are_read_as_none(opened, tmp_path, name):
    opened(name).close(replace(report(0), cycles=(CycleReport("ERROR", grip_force_n=math.nan),)))
    assert read_report(tmp_path / name).cycles[0].grip_force_n is None


def test_keys_of_later_versions_are_left_out(tmp_path):
    path = tmp_path / "report.json"
    path.write_text(json.dumps({"tree": "t", "seed": 1, "status": "SUCCESS", "mood": "good"}))
    assert read_report(path) == RunReport("t", 1, "SUCCESS")


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("a.json", b"{", "is not a report"),
        ("a.json", b"[]", "expected an object, got \\[\\]"),
        ("a.json", b'{"tree": "t"}', "missing"),
        ("a.json", b'{"tree": "t", "seed": 1, "status": "", "cycles": 3}', "expected an array"),
        ("a.json", b"\xff\xfe", "is not a report"),
        ("a.json", b"[" * 100_000, "is not a report"),
        ("a.jsonl", b'{"type": "run"}\n{"ty\n', "line 2"),
        ("a.jsonl", b"[]\n", "line 1"),
        ("a.jsonl", b'{"type": "cycle"}\n', "duration_s"),
        ("b.json", None, "cannot be read: No such file"),
    ],
)
def test_what_is_no_report_is_refused(tmp_path, name, content, problem):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(BtManipError, match=f"{name}' .*{problem}"):
        read_report(Path(tmp_path / name))


@FORMATS
def test_a_report_is_locked_until_it_is_closed(opened, tmp_path, name, monkeypatch):
    monkeypatch.setattr(report_file, "PERIOD", 0.0)
    monkeypatch.setattr(report_file, "SHARE", 1e9)  # a JSON report is written at once
    file = opened(name)
    for cycles in range(3):
        file.update(report(cycles))
        with pytest.raises(FileInUseError):
            opened(name).update(report(5))
    file.close(report(3, "SUCCESS"))
    assert read_report(tmp_path / name) == report(3, "SUCCESS")
    opened(name).close(report(1, "SUCCESS"))


def test_run_and_cycle_have_the_agreed_keys():
    written = json.loads(replace(report(1), versions=versions()).to_json())
    (cycle,) = written["cycles"]
    assert {
        "tree", "seed", "status", "cycles", "simulated_s", "wall_s", "real_time_factor",
        "state_digest", "versions",
    } <= set(written)  # fmt: skip
    assert written["versions"]["mujoco"][0].isdigit()
    assert "python" in written["versions"]
    assert {
        "status", "object", "placed", "duration_s", "phases", "grip_force_n",
        "max_tracking_error_rad", "limits", "saturated_steps", "unexpected_contacts",
    } <= set(cycle)  # fmt: skip
    assert cycle["limits"] == {
        "position": 0.5, "velocity": 0.6, "acceleration": 0.7, "jerk": 0.8, "effort": 0.9,
    }  # fmt: skip
    assert cycle["unexpected_contacts"] == [["panda/hand", "table"]]
    assert cycle["phases"] == [
        {
            "behaviour": "Grasp", "name": "grasp it", "status": "FAILURE",
            "reason": "the fingers met", "start_s": 1.5, "duration_s": 0.25,
        }
    ]  # fmt: skip


def test_the_use_of_leaves_is_summed_over_cycles():
    use = LeafUse()
    use.add({"RunPolicy": LeafTime(0.5, ("pushed by 3.5 N",))}, 4.0)
    use.add({"RunPolicy": LeafTime(0.0, ("not finite", "pushed by 4.5 N"))}, 2.0)
    use.add({"RunPolicy": LeafTime(1.0)}, 2.0)
    assert use.sentences("cycles") == [
        "RunPolicy ran in 2 of 3 cycles, for 50.0% of the time: 2 x pushed by 3.5 N; "
        "1 x not finite."
    ]
    assert LeafUse().sentences("cycles") == []
