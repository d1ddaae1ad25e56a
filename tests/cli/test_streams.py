"""Whatever becomes of the output, a run goes on to its end."""

import json
import os
import subprocess
import sys

import pytest

TREE = """
from bt_manip.bt import Action, Sequence, Sleep, Status

class Loud(Action):
    def update(self):
        print("größer")
        return Status.SUCCESS

def tree():
    return Sequence("größer", [Sleep("rést", msec=20), Loud()])

"""
RUN = ("run", "loud.py:tree", "--report", "r.json", "--cycles", "3")


@pytest.fixture(autouse=True)
def loud(write):
    write(TREE, "loud.py")


def check_report(folder) -> None:
    report = json.loads((folder / "r.json").read_text())
    assert [cycle["status"] for cycle in report["cycles"]] == ["SUCCESS"] * 3


def full():
    return open("/dev/full", "w")


def pipe_without_reader():
    read, write = os.pipe()
    os.close(read)
    return os.fdopen(write, "w")


@pytest.mark.parametrize(
    ("output", "reason"),
    [(full, "No space left on device"), (pipe_without_reader, "Broken pipe")],
)
def test_output_that_is_lost_is_one_warning(bt_manip, folder, monkeypatch, output, reason):
    monkeypatch.setattr(sys, "stdout", output())
    code, _, err = bt_manip(*RUN)
    assert code == 0
    assert err == f"Warning: standard output: {reason}; nothing more is printed there\n"
    check_report(folder)


def test_a_run_needs_no_standard_streams(folder):
    command = f"'{sys.executable}' -m bt_manip {' '.join(RUN)} <&- >&- 2>&-"
    assert subprocess.run(["bash", "-c", command], timeout=60).returncode == 0
    check_report(folder)


def test_what_the_terminal_cannot_show_is_escaped(bt_manip, folder, monkeypatch):
    monkeypatch.setattr(sys, "stdout", open("out", "w", encoding="ascii"))
    assert bt_manip(*RUN[:-2]).code == 0
    sys.stdout.flush()
    text = (folder / "out").read_text()
    assert "r\\xe9st" in text and "gr\\xf6\\xdfer" in text


def test_bad_input_is_2_without_an_error_stream(bt_manip, monkeypatch):
    monkeypatch.setattr(sys, "stderr", full())
    assert bt_manip("run", "nothing").code == 2


def test_a_list_that_cannot_be_written_is_one_error(bt_manip, monkeypatch):
    monkeypatch.setattr(sys, "stdout", full())
    code, _, err = bt_manip("list", "controllers")
    assert (code, err) == (3, "Error: standard output: No space left on device\n")


# Views that raise


def no_ink(*arguments, **options):
    raise RuntimeError("no ink")


@pytest.mark.parametrize("method", ["run_started", "after_tick", "run_ended"])
def test_a_view_that_raises_is_dropped_with_one_warning(bt_manip, folder, monkeypatch, method):
    monkeypatch.setattr(f"bt_manip.viewer.PlainView.{method}", no_ink, raising=False)
    code, _, err = bt_manip(*RUN)
    assert code == 0
    (line,) = err.splitlines()
    assert line.startswith("Warning: the view in the terminal is not called again")
    assert "RuntimeError: no ink" in line
    check_report(folder)


def test_a_terminal_view_that_raises_leaves_the_terminal_as_it_was(bt_manip, screen, monkeypatch):
    monkeypatch.setattr("bt_manip.viewer.terminal_view.tree_lines", no_ink)
    read = screen()
    code, _, err = bt_manip(*RUN)
    shown = read()
    assert code == 0 and "Warning: the view in the terminal is not called again" in err + shown
    assert "3 of 3 cycles succeeded" in shown
    assert shown.rfind("\x1b[?25h") > shown.rfind("\x1b[?25l")


def test_a_table_that_cannot_be_printed_leaves_the_exit_code(bt_manip, trees, monkeypatch):
    monkeypatch.setattr("bt_manip.cli.cycle_table.print_cycles", no_ink)
    code, _, err = bt_manip("run", f"{trees}:failing")
    assert code == 1
    assert err == "Warning: the results are not shown: RuntimeError: no ink\n"
