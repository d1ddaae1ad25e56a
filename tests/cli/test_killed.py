"""A killed run leaves its report and its trace."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from bt_manip.record import read_report
from bt_manip_recording import read_trace

PROBE = """
import os
import time
from bt_manip import hookimpl

FILE = os.open("ended", os.O_WRONLY | os.O_CREAT)

@hookimpl
def cycle_ended(station):
    os.write(FILE, b"%.17g %.17g\\n" % (time.monotonic(), station.cell.time))
"""

LATENCY = 0.3
"""Wall time that writing a report and killing a process may take on a loaded machine [s]."""

BUFFERED = 0.256
"""Simulated time of the control steps that a trace may lack [s]."""


def run_and_kill(tree: str, folder: Path, name: str, after: float) -> tuple[float, np.ndarray]:
    """Kill a run some time after its first cycle [s]; return when, and when its cycles had ended.

    These are wall times; the second column of the cycles is simulated time [s].
    """
    (folder / "plugins").mkdir()
    (folder / "plugins" / "probe.py").write_text(PROBE)
    command = [sys.executable, "-m", "bt_manip", "run", tree, "--cycles", "0", "--quiet"]
    command += ["--report", name, "--trace", "run.npz", "--plugins-dir", "plugins"]
    ended = folder / "ended"
    with subprocess.Popen(command, cwd=folder) as process:
        try:
            deadline = time.monotonic() + 60.0
            while not (ended.exists() and ended.stat().st_size):
                assert time.monotonic() < deadline and process.poll() is None
                time.sleep(0.01)
            time.sleep(after)
            at = time.monotonic()
        finally:
            process.kill()
    assert process.returncode == -signal.SIGKILL
    return at, np.loadtxt(ended, ndmin=2)


MOMENTS = [
    pytest.param(name, after, marks=pytest.mark.soak)
    for seed in range(49)
    for name, after in zip(
        ("r.jsonl", "r.json"), np.random.default_rng(seed).uniform(0.0, 2.0, 2), strict=True
    )
]


@pytest.mark.parametrize(("name", "after"), [("r.jsonl", 0.1), ("r.json", 1.5), *MOMENTS])
def test_a_run_killed_at_any_moment_leaves_the_cycles_that_had_ended(trees, tmp_path, name, after):
    at, ended = run_and_kill(f"{trees}:quick", tmp_path, name, after)
    report = read_report(tmp_path / name)
    assert report.status == "ERROR" and "ended without an end" in report.error
    assert report.robot == "panda"
    # A line is written before the probe; the other form now and then.
    written = ended if name == "r.jsonl" else ended[ended[:, 0] < at - 1.0 - LATENCY]
    assert len(written) <= len(report.cycles) <= len(ended) + 1
    assert read_trace(tmp_path / "run.npz")["t"][-1] > ended[-1, 1] - BUFFERED
