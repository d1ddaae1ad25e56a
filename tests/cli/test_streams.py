"""Whatever becomes of the output, a run goes on to its end."""

import json
import subprocess
import sys
from collections.abc import Callable
from typing import NamedTuple

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


class Ended(NamedTuple):
    """A run in a shell, and the statuses of the cycles in its report."""

    text: str
    cycles: list[str]


@pytest.fixture
def shell(tmp_path) -> Callable[..., Ended]:
    """Run three cycles in a shell that prints the exit codes of the pipeline at last."""
    (tmp_path / "loud.py").write_text(TREE)
    command = f"'{sys.executable}' -m bt_manip run loud.py:tree --report r.json"

    def run(redirection: str, before: str = "", *, cycles: int = 3) -> Ended:
        script = (
            f"{before} {command} --cycles {cycles} {redirection}; echo codes ${{PIPESTATUS[*]}}"
        )
        done = subprocess.run(
            ["bash", "-c", script], cwd=tmp_path, timeout=60,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        report = json.loads((tmp_path / "r.json").read_text())
        return Ended(done.stdout.decode(), [cycle["status"] for cycle in report["cycles"]])

    return run


@pytest.mark.parametrize(
    ("redirection", "codes"),
    [
        ("| head -1", "0 0"),
        ("<&- >&- 2>&-", "0"),
        (">&- 2>/dev/full", "0"),
        (">/dev/full 2>&1", "0"),
    ],
)
def test_output_that_cannot_be_written_is_dropped(shell, redirection, codes):
    text, cycles = shell(redirection)
    assert cycles == ["SUCCESS"] * 3
    assert text.splitlines()[-1] == f"codes {codes}"
    assert "Traceback" not in text
    assert "Exception" not in text


def test_output_that_is_lost_is_one_warning(shell):
    text, _ = shell("2>&1 >/dev/full | cat")
    warning = "Warning: standard output: No space left on device; nothing more is printed there"
    assert text.splitlines()[:-1] == [warning]


def test_what_the_terminal_cannot_show_is_escaped(shell):
    text, cycles = shell("", before="PYTHONIOENCODING=ascii", cycles=1)
    assert cycles == ["SUCCESS"]
    assert "r\\xe9st" in text and "gr\\xf6\\xdfer" in text
    assert text.splitlines()[-1] == "codes 0"


def test_bad_input_is_2_without_an_error_stream(bt_manip, tmp_path):
    command = [sys.executable, "-m", "bt_manip", "run", "nothing"]
    with open("/dev/full", "w") as full:
        assert subprocess.run(command, stderr=full, timeout=60).returncode == 2


def test_a_list_that_cannot_be_written_is_one_error():
    command = [sys.executable, "-m", "bt_manip", "list", "controllers"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, timeout=60)
    assert done.returncode == 3
    assert done.stderr == b"Error: standard output: No space left on device\n"


# Views that raise


@pytest.mark.parametrize(
    "method", ["run_started", "after_tick", "cycle_started", "cycle_ended", "run_ended"]
)
def test_a_view_that_raises_is_dropped_with_one_warning(
    bt_manip, trees, tmp_path, monkeypatch, method
):
    def fail(self, *arguments):
        raise RuntimeError("no ink")

    monkeypatch.setattr(f"bt_manip.viewer.PlainView.{method}", fail, raising=False)
    code, _, err = bt_manip("run", f"{trees}:quick", "--cycles", 2, "--report", tmp_path / "r.json")
    assert code == 0
    (line,) = err.splitlines()
    assert line.startswith("Warning: the view in the terminal is not called again")
    assert "RuntimeError: no ink" in line
    assert json.loads((tmp_path / "r.json").read_text())["status"] == "SUCCESS"


def test_a_terminal_view_that_raises_leaves_the_terminal_as_it_was(terminal, tmp_path):
    (tmp_path / "torn.py").write_text(TORN)
    shell = terminal("run", "torn.py:tree")
    assert shell.end() == 0
    shown = shell.shown.decode()
    assert "Warning: the view in the terminal is not called again" in shown
    assert "1 of 1 cycles succeeded" in shown
    assert shown.rfind("\x1b[?25h") > shown.rfind("\x1b[?25l")


TORN = """
from bt_manip.bt import Sleep
from bt_manip.viewer import TerminalView

def torn(self, now):
    raise RuntimeError("no ink")

TerminalView._picture = torn

def tree():
    return Sleep("rest", msec=20)
"""


def test_a_table_that_cannot_be_printed_leaves_the_exit_code(bt_manip, trees, monkeypatch):
    def fail(*arguments):
        raise RuntimeError("no ink")

    monkeypatch.setattr("bt_manip.cli.cycle_table.print_cycles", fail)
    code, _, err = bt_manip("run", f"{trees}:failing")
    assert code == 1
    assert err == "Warning: the results are not shown: RuntimeError: no ink\n"
