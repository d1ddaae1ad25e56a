"""Ctrl-C at any moment: 130, the report, a whole terminal."""

import json
import os
import pty
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bt_manip.cli.interrupt import Interrupt


@pytest.fixture
def interrupt() -> Iterator[Interrupt]:
    before = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM)}
    interrupt = Interrupt()
    interrupt.install()
    yield interrupt
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    for number, handler in before.items():
        signal.signal(number, handler)


def test_the_second_one_is_harmless(interrupt):
    with pytest.raises(KeyboardInterrupt), interrupt.raised():
        signal.raise_signal(signal.SIGINT)
    with interrupt.held():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGTERM)
    assert interrupt.exit_code == 130


def test_at_first_it_is_held_and_only_sets_a_flag(interrupt):
    signal.raise_signal(signal.SIGINT)
    assert interrupt.requested
    with pytest.raises(KeyboardInterrupt), interrupt.raised():
        pytest.fail("it came before and is raised at the beginning")


def test_within_held_it_can_be_raised_and_held_again(interrupt):
    with interrupt.held():
        with pytest.raises(KeyboardInterrupt), interrupt.raised():
            signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)


def test_a_run_that_does_not_stop_is_stopped(interrupt, monkeypatch):
    monkeypatch.setattr("bt_manip.cli.interrupt.PATIENCE", 0.01)
    with pytest.raises(KeyboardInterrupt), interrupt.patient():
        signal.raise_signal(signal.SIGINT)
        assert interrupt.requested
        signal.pause()


def test_a_run_that_stops_is_left_alone(interrupt):
    with interrupt.patient():
        signal.raise_signal(signal.SIGINT)
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


def test_termination_has_its_own_code(interrupt):
    signal.raise_signal(signal.SIGTERM)
    assert interrupt.exit_code == 143


# The whole program, in a process and at a terminal of its own.

HIDE, SHOW = b"\x1b[?25l", b"\x1b[?25h"


class Terminal:
    """A program that believes to be in front of a person."""

    def __init__(self, *command: str, cwd: Path) -> None:
        self.shown = b""
        self._own, theirs = pty.openpty()
        environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "40"}
        self._process = subprocess.Popen(
            command, stdin=theirs, stdout=theirs, stderr=theirs, cwd=cwd, env=environment
        )
        os.close(theirs)

    def wait_for(self, text: bytes) -> None:
        deadline = time.monotonic() + 60.0  # [s] of a hopeless wait, not of a passing test
        while text not in self.shown:
            if time.monotonic() > deadline or not self._read():
                raise AssertionError(f"{text!r} never came:\n{self.shown.decode()}")

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def end(self) -> int:
        while self._read():
            pass
        os.close(self._own)
        return self._process.wait(30)

    def _read(self) -> bool:
        ready, _, _ = select.select([self._own], [], [], 60)
        try:
            data = os.read(self._own, 65536) if ready else b""
        except OSError:  # the other end is closed
            data = b""
        self.shown += data
        return bool(data)


@pytest.fixture
def terminal(tmp_path) -> Iterator[Callable[..., Terminal]]:
    started: list[Terminal] = []

    def start(*arguments: str) -> Terminal:
        started.append(Terminal(sys.executable, "-m", "bt_manip", *arguments, cwd=tmp_path))
        return started[-1]

    yield start
    for each in started:
        each._process.kill()
        each._process.wait(30)


def test_in_the_middle_of_a_run(terminal, trees, tmp_path):
    shell = terminal("run", f"{trees}:endless", "--cycles", "0", "--report", "r.json")
    shell.wait_for(b"real time")
    shell.interrupt()
    shell.interrupt()
    assert shell.end() == 130
    assert b"Traceback" not in shell.shown
    assert shell.shown.rfind(SHOW) > shell.shown.rfind(HIDE)
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["status"] == "INTERRUPTED"
    assert report["simulated_s"] > 0.0
    assert report["cycles"][0]["status"] == "INTERRUPTED"


SLOW = """
import signal, sys
print("importing", flush=True)
signal.pause()
"""


def test_during_the_imports(terminal, tmp_path):
    """The tree's module stands for anything whose import takes a while."""
    (tmp_path / "slow.py").write_text(SLOW)
    shell = terminal("run", "slow.py:tree", "--report", "r.json")
    shell.wait_for(b"importing")
    shell.interrupt()
    shell.interrupt()
    assert shell.end() == 130
    assert b"Traceback" not in shell.shown
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["status"] == "INTERRUPTED"
    assert report["cycles"] == []
    assert set(report) >= {"tree", "seed", "state_digest", "versions", "simulated_s"}


HANGING = """
import signal
from bt_manip.bt import Action

class Hang(Action):
    def update(self):
        print("hanging", flush=True)
        while True:
            signal.pause()

def tree():
    return Hang()
"""


def test_in_a_behaviour_that_hangs(terminal, tmp_path):
    (tmp_path / "hanging.py").write_text(HANGING)
    shell = terminal("run", "hanging.py:tree", "--report", "r.json")
    shell.wait_for(b"hanging")
    shell.interrupt()
    assert shell.end() == 130
    assert b"Traceback" not in shell.shown
    assert SHOW in shell.shown
    assert json.loads((tmp_path / "r.json").read_text())["status"] == "INTERRUPTED"
