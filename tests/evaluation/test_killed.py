"""An evaluation goes on after kill -9 of a worker and of itself, with the same results."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bt_manip.evaluation import EpisodeId, EpisodeWorker, evaluate, read_results
from bt_manip.evaluation.results import JOURNAL
from tests.support.program import run_program

pytest.importorskip("pyarrow")
from pyarrow import parquet

HOPELESS = 120.0
"""Wall time without a further result after which a test that waits has failed [s]."""


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
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def test_an_evaluation_goes_on_after_kill_9(evaluation, in_this_process, tmp_path, capfd):
    """A worker and the driver are killed; the same command runs the other episodes."""
    small, folder, episodes = evaluation(), tmp_path / "out", 12
    command = "evaluate", small.tree, "--scene", small.options["scene"], "--to", str(folder)
    command = *command, "--episodes", str(episodes), "--workers"
    words = sys.executable, "-m", "bt_manip", *command, "2"
    driver = subprocess.Popen(words, stderr=subprocess.DEVNULL)
    try:
        wait_for_rows(folder, 1, driver)
        os.kill(workers_of(driver.pid)[0], signal.SIGKILL)
        wait_for_rows(folder, 4, driver)
        orphans = workers_of(driver.pid)
    finally:
        driver.kill()
        driver.wait()
    deadline = time.monotonic() + HOPELESS
    while not all(map(gone, orphans)):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    known = read_results(folder)[1]
    assert 4 <= len(known) < episodes
    assert run_program(*command, "1") in (0, 1)
    assert f"{len(known)} episodes are known" in capfd.readouterr().err
    found = read_results(folder)[1]
    assert [one.episode for one in found] == list(range(episodes))
    assert all(one in found and one.status != "DIED" for one in known)
    worker = EpisodeWorker(small)
    for one in known:
        assert worker.run(EpisodeId(0, one.episode)).digest == one.digest


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
