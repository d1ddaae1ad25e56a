"""An evaluation goes on after kill -9 of a worker and of itself, with the same results."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bt_manip.evaluation import EpisodeId, EpisodeWorker, evaluate
from bt_manip.evaluation.results import JOURNAL

pytest.importorskip("pyarrow")
from pyarrow import parquet

HOPELESS = 120.0
"""Wall time without a further result after which a test that waits has failed [s]."""


@pytest.mark.soak
def test_workers_that_leave_are_failed_rows(evaluation):
    rows = list(evaluate(evaluation("leaving"), 2, 2))
    assert {row.episode for row in rows} == {0, 1}
    assert {(row.success, row.status, row.reason) for row in rows} == {
        (False, "DIED", "its process ended with exit code 0")
    }


def rows_in(folder: Path) -> int:
    """Count the results in a folder that another process writes."""
    journal = folder / JOURNAL
    latest = journal.read_bytes().count(b"\n") if journal.exists() else 0
    return latest + sum(parquet.read_metadata(p).num_rows for p in folder.glob("part-*"))


def workers_of(process: int) -> list[int]:
    """Return the processes that the fork server of a process has started."""
    names = {pid: Path(f"/proc/{pid}/cmdline").read_text() for pid in children_of(process)}
    return children_of(*(pid for pid, name in names.items() if "forkserver" in name))


def children_of(process: int) -> list[int]:
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return [int(pid) for pid in children]


def wait_for_rows(folder: Path, count: int, driver: "subprocess.Popen[bytes]") -> None:
    known, deadline = 0, time.monotonic() + HOPELESS
    while known < count:
        if (now := rows_in(folder)) > known:
            known, deadline = now, time.monotonic() + HOPELESS
        assert driver.poll() is None and time.monotonic() < deadline
        time.sleep(0.02)


def gone(process: int) -> bool:
    """Return whether a process has ended."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def check_goes_on(command: list[str], folder: Path, episodes: int) -> dict[int, str]:
    """Kill a worker and the driver, start it again, and return the digests of all episodes."""
    command = [sys.executable, "-m", "bt_manip", *command, "--to", str(folder), "--workers"]
    driver = subprocess.Popen([*command, "2"], stderr=subprocess.DEVNULL)
    try:
        wait_for_rows(folder, episodes // 10, driver)
        os.kill(workers_of(driver.pid)[0], signal.SIGKILL)
        wait_for_rows(folder, episodes // 3, driver)
        orphans = workers_of(driver.pid)
    finally:
        driver.kill()
        driver.wait()
    known = rows_in(folder)
    assert known < episodes
    deadline = time.monotonic() + HOPELESS
    while not all(map(gone, orphans)):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert rows_in(folder) == known
    workers = "1" if episodes < 100 else "2"
    again = subprocess.run([*command, workers], capture_output=True, text=True)
    assert again.returncode in (0, 1) and f"{known} episodes are known" in again.stderr
    table = parquet.read_table(folder)
    numbers, digests = (table[name].to_pylist() for name in ("episode", "digest"))
    assert sorted(numbers) == list(range(episodes))
    assert "DIED" not in table["status"].to_pylist()
    return dict(zip(numbers, digests, strict=True))


@pytest.mark.parametrize("episodes", [12, pytest.param(1000, marks=pytest.mark.soak)])
def test_an_evaluation_goes_on_after_kill_9(evaluation, tmp_path, episodes):
    small = evaluation()
    command = ["evaluate", small.tree, "--scene", small.options["scene"], "--episodes"]
    found = check_goes_on([*command, str(episodes)], tmp_path / "out", episodes)
    worker = EpisodeWorker(small)
    assert found == {n: worker.run(EpisodeId(0, n)).digest for n in range(episodes)}


@pytest.mark.soak
def test_a_ray_cluster_gives_the_same_results_also_when_an_actor_dies(evaluation):
    pytest.importorskip("ray")
    from functools import partial

    from bt_manip_learn import RayPool

    small = evaluation()
    pool = RayPool(partial(EpisodeWorker, small), workers=2)
    found = {}
    for result in evaluate(small, 20, 2, pool=pool):
        found[result.episode] = result.digest
        if len(found) == 5:
            os.kill(actors()[0], signal.SIGKILL)
    worker = EpisodeWorker(small)
    assert found == {n: worker.run(EpisodeId(0, n)).digest for n in range(20)}


def actors() -> list[int]:
    """Return the processes of the actors that descend from this process."""
    known, found = {os.getpid()}, []
    for path in sorted(Path("/proc").glob("[0-9]*"), key=lambda one: int(one.name)):
        try:
            parent = int((path / "stat").read_text().rpartition(")")[2].split()[1])
            name = (path / "cmdline").read_text()
        except OSError:
            continue
        if parent in known:
            known.add(int(path.name))
            if "_RemoteWorker" in name:
                found.append(int(path.name))
    return found
