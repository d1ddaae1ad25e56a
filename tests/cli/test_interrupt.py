"""Ctrl-C at any moment: 130, the report, a whole terminal."""

import json
import signal
from collections.abc import Callable

import numpy as np
import pytest

from bt_manip.cli.app import run_app
from bt_manip.record import read_report


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
    with interrupt.held(), pytest.raises(KeyboardInterrupt), interrupt.raised():
        pytest.fail("it came before and is raised at the beginning")


def test_a_run_that_does_not_stop_is_stopped(interrupt, monkeypatch):
    monkeypatch.setattr("bt_manip.cli.interrupt.PATIENCE", 0.01)
    with pytest.raises(SystemExit), interrupt.patient():
        signal.raise_signal(signal.SIGINT)
        assert interrupt.requested
        signal.pause()


def test_a_run_that_stops_is_left_alone_and_one_that_is_told_twice_is_one(interrupt):
    with interrupt.patient():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0.0


def test_the_second_one_ends_a_run_at_once_and_all_others_are_harmless(interrupt, monkeypatch):
    monkeypatch.setattr("bt_manip.cli.interrupt.ONE_PRESS", 0.0)
    with interrupt.patient():
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGXCPU, 152)]
)
def test_other_signals_have_their_own_codes(interrupt, number, code):
    signal.raise_signal(number)
    assert interrupt.requested
    assert interrupt.exit_code == code


def test_a_limit_of_cpu_time_signals_again_and_again(interrupt, monkeypatch):
    monkeypatch.setattr("bt_manip.cli.interrupt.ONE_PRESS", 0.0)
    with interrupt.patient():
        for _ in range(3):
            signal.raise_signal(signal.SIGXCPU)
    assert interrupt.exit_code == 152


def test_nohup_keeps_its_effect(interrupt):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    interrupt.install()
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


# A run whose arm is moving; the tree itself presses the key.

PRESSING = """
import signal
from bt_manip.bt import Action, Status

class Press(Action):
    def setup(self, *, arm, **_):
        self.arm, self.ticks = arm, 0

    def update(self):
        self.ticks += 1
        if self.ticks == 1:
            self.arm.move_to_configuration(self.arm.q + 0.5)
        if self.ticks == 20:
            signal.raise_signal(signal.SIGINT)
            {then}
        return Status.RUNNING

    def terminate(self, new_status):
        {halted}

def tree():
    return Press()
"""


@pytest.fixture
def pressed(interrupt, tmp_path) -> Callable[..., np.ndarray]:
    """Run, and give the velocities of the reference."""

    def run(then: str = "pass", halted: str = "pass") -> np.ndarray:
        (tmp_path / "tree.py").write_text(PRESSING.format(then=then, halted=halted))
        files = "--report", str(tmp_path / "r.json"), "--trace", str(tmp_path / "t.npz")
        assert run_app(interrupt, ["run", f"{tmp_path}/tree.py:tree", *files]) == 130
        report = json.loads((tmp_path / "r.json").read_text())
        assert report["status"] == report["cycles"][0]["status"] == "INTERRUPTED"
        with np.load(tmp_path / "t.npz") as rows:
            return rows["v_ref"]

    return run


def came_to_rest(v_ref: np.ndarray) -> bool:
    assert abs(np.diff(v_ref, axis=0)).max() < 0.05  # nowhere stopped dead
    return len(v_ref) > 200 and not v_ref[-1].any()


def test_the_arm_is_braked_before_the_run_ends(pressed):
    assert came_to_rest(pressed())


def test_the_arm_is_braked_where_its_behaviour_hangs(pressed, monkeypatch):
    monkeypatch.setattr("bt_manip.cli.interrupt.PATIENCE", 0.5)
    assert came_to_rest(pressed(then="signal.pause()"))


def test_the_second_one_ends_it_without_braking(pressed, monkeypatch):
    monkeypatch.setattr("bt_manip.cli.interrupt.ONE_PRESS", 0.0)
    v_ref = pressed(halted="signal.raise_signal(signal.SIGINT)")
    assert len(v_ref) == 200 and abs(v_ref[-1]).max() > 0.1


IMPORTED = """
import signal
import time

signal.raise_signal(signal.SIGINT)
signal.raise_signal(signal.SIGINT)
time.sleep(60)
"""


def test_during_the_imports(interrupt, tmp_path):
    """The tree's module stands for anything whose import takes a while."""
    (tmp_path / "slow.py").write_text(IMPORTED)
    arguments = ["run", f"{tmp_path}/slow.py:tree", "--report", str(tmp_path / "r.json")]
    assert run_app(interrupt, arguments) == 130
    report = json.loads((tmp_path / "r.json").read_text())
    assert (report["status"], report["cycles"]) == ("INTERRUPTED", [])
    assert set(report) >= {"tree", "seed", "state_digest", "versions", "simulated_s"}


# The whole program, in a process and at a terminal of its own.

HIDE, SHOW = b"\x1b[?25l", b"\x1b[?25h"


def test_in_the_middle_of_a_run(terminal, trees, tmp_path):
    shell = terminal("run", f"{trees}:endless", "--cycles", "0", "--report", "r.json")
    shell.wait_for(b"real time")
    shell.interrupt()
    shell.interrupt()
    assert shell.end() == 130
    assert b"Traceback" not in shell.shown
    assert b"The run was interrupted before a cycle was complete, after " in shell.shown
    assert shell.shown.rfind(SHOW) > shell.shown.rfind(HIDE)
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["status"] == "INTERRUPTED"
    assert report["simulated_s"] > 0.0
    assert report["cycles"][0]["status"] == "INTERRUPTED"


def test_a_terminal_that_is_closed_leaves_the_report(terminal, trees, tmp_path):
    shell = terminal("run", f"{trees}:quick", "--cycles", "0", "--report", "r.jsonl")
    shell.wait_for(b"cycle 2")
    assert shell.hang_up(signal.SIGHUP) == 129
    report = read_report(tmp_path / "r.jsonl")
    assert report.status == "INTERRUPTED"
    assert report.cycles[0].status == "SUCCESS"
