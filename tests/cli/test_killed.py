"""A killed run leaves its report and its trace."""

import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from bt_manip.record import read_report
from bt_manip_recording import read_trace

PROBE = """
import os
import time
from bt_manip import hookimpl

FILE = os.open("{name}.ended", os.O_WRONLY | os.O_CREAT)

@hookimpl
def cycle_ended(station):
    os.write(FILE, b"%.17g %.17g\\n" % (time.monotonic(), station.cell.time))
"""

LATENCY = 0.3
"""Wall time that writing a report and killing a process may take on a loaded machine [s]."""

BUFFERED = 0.256
"""Simulated time of the control steps that a trace may lack [s]."""


class Killed(NamedTuple):
    """A process that was killed, and the cycles that had ended by its own account."""

    folder: Path
    name: str
    at: float  # [s], wall time
    ended: list[tuple[float, float]]  # [s], wall time and simulated time


@pytest.fixture
def killed(trees, tmp_path) -> Iterator[Callable[..., Killed]]:
    """Start a run for each name of a report, and kill it some time after its first cycle."""
    started: dict[str, subprocess.Popen[bytes]] = {}

    def start(*names: str) -> None:
        for name in names:
            plugins = tmp_path / f"{name}.plugins"
            plugins.mkdir()
            (plugins / "probe.py").write_text(textwrap.dedent(PROBE.format(name=name)))
            files = "--report", name, "--trace", f"{name}.npz", "--plugins-dir", str(plugins)
            command = sys.executable, "-m", "bt_manip", "run", f"{trees}:quick", "--cycles", "0"
            started[name] = subprocess.Popen([*command, *files, "--quiet"], cwd=tmp_path)

    def kill(name: str, after: float) -> Killed:
        ended = tmp_path / f"{name}.ended"
        deadline = time.monotonic() + 60.0
        while not (ended.exists() and ended.stat().st_size):
            assert time.monotonic() < deadline and started[name].poll() is None
            time.sleep(0.01)
        time.sleep(after)
        at = time.monotonic()
        started[name].kill()
        assert started[name].wait(30) == -signal.SIGKILL
        rows = [line.split() for line in ended.read_text().splitlines(keepends=True)]
        return Killed(tmp_path, name, at, [(float(t), float(s)) for t, s in rows])

    def run(*after: float) -> tuple[Killed, Killed]:
        start("r.jsonl", "r.json")
        return kill("r.jsonl", after[0]), kill("r.json", after[1])

    yield run
    for process in started.values():
        process.kill()
        process.wait(30)


def check(lines: Killed, json: Killed) -> None:
    report = read_report(lines.folder / lines.name)
    assert report.status == "ERROR" and "ended without an end" in report.error
    assert report.robot == "panda"
    assert len(report.cycles) - len(lines.ended) in (0, 1)  # it is written before the probe
    report = read_report(json.folder / json.name)
    assert report.status == "ERROR" and "ended without an end" in report.error
    before = [wall for wall, _ in json.ended if wall < json.at - 1.0 - LATENCY]
    assert len(before) <= len(report.cycles) <= len(json.ended) + 1
    for each in (lines, json):
        t = read_trace(each.folder / f"{each.name}.npz")["t"]
        assert t[-1] > each.ended[-1][1] - BUFFERED


MOMENTS = [np.random.default_rng(seed).uniform(0.0, 2.0, 2) for seed in range(49)]


@pytest.mark.parametrize(
    "after", [(0.1, 1.5), *(pytest.param(two, marks=pytest.mark.soak) for two in MOMENTS)]
)
def test_a_run_killed_at_any_moment_leaves_the_cycles_that_had_ended(killed, after):
    check(*killed(*after))
