"""Episodes run in parallel processes; an episode whose process died runs again."""

import multiprocessing
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from unittest.mock import Mock

import pytest

from bt_manip.evaluation import ProcessPool, WorkerDiedError, call_in_process, run_episodes
from bt_manip.exceptions import BtManipError


class Squares:
    """A worker whose episodes 3 and above kill their process the first few times."""

    def __init__(self, folder: Path, deaths: int) -> None:
        self._folder, self._deaths = folder, deaths

    def run(self, episode: int) -> tuple[int, int]:
        if episode < 0:
            raise BtManipError(f"{episode} is negative")
        if episode >= 3:
            (self._folder / f"{episode}-{os.getpid()}").touch()
            if len(list(self._folder.glob(f"{episode}-*"))) <= self._deaths:
                os.kill(os.getpid(), signal.SIGKILL)
        return episode * episode, os.getpid()


class Environment:
    def run(self, name: str) -> str:
        return os.environ.get(name, "")


class ConfusedError(BtManipError):
    """An error that cannot be copied to another process."""

    def __init__(self, message: str, *, reason: str) -> None:
        super().__init__(message)
        self.reason = reason


def confuse() -> None:
    raise ConfusedError("so many", reason="none")


FIRST = """
from bt_manip.evaluation import ProcessPool

pool = ProcessPool(float)
print(open(f"/proc/{pool.start()._process.pid}/status").read())
pool.close()
"""
"""Prints the status of the first process that an interpreter starts."""


@pytest.fixture
def squares(tmp_path):
    return lambda deaths=0: partial(Squares, tmp_path, deaths)


def test_all_episodes_run_in_as_many_processes_as_asked_for(squares):
    results = list(run_episodes(squares(), range(40), 2))
    assert sorted(result for result, _ in results) == [n * n for n in range(40)]
    processes = {process for _, process in results}
    assert len(processes) == 2 and os.getpid() not in processes


def test_a_process_has_one_thread_for_linear_algebra_unless_told_otherwise(monkeypatch):
    monkeypatch.delenv("MUJOCO_GL")  # so that each process is an interpreter of its own
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    assert list(run_episodes(Environment, ["OPENBLAS_NUM_THREADS"], 2)) == ["1"]
    assert "OPENBLAS_NUM_THREADS" not in os.environ
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    assert list(run_episodes(Environment, ["OPENBLAS_NUM_THREADS"], 2)) == ["3"]


def test_one_job_runs_in_this_process_unless_there_is_a_pool(squares):
    assert list(run_episodes(squares(), range(3), 1)) == [(n * n, os.getpid()) for n in range(3)]
    ((square, process),) = run_episodes(squares(), [2], 1, pool=ProcessPool(squares()))
    assert square == 4 and process != os.getpid()


def test_a_function_is_called_in_another_process():
    assert call_in_process("the call", os.getpid) != os.getpid()
    with pytest.raises(WorkerDiedError, match=r"^the call: its process ended with exit code 3$"):
        call_in_process("the call", partial(os._exit, 3))
    with pytest.raises(BtManipError, match=r"^so many"):
        call_in_process("the call", confuse)


def test_ctrl_c_does_not_reach_the_first_process_either():
    status = subprocess.run([sys.executable, "-c", FIRST], capture_output=True, text=True).stdout
    (blocked,) = (line.split()[1] for line in status.splitlines() if line.startswith("SigBlk"))
    assert int(blocked, 16) & 1 << signal.SIGINT - 1


def test_an_episode_whose_process_died_runs_again(squares):
    results = list(run_episodes(squares(2), range(5), 2))
    assert sorted(result for result, _ in results) == [0, 1, 4, 9, 16]


def test_an_episode_that_kills_every_process_is_given_up_or_gets_a_result(squares):
    results = list(run_episodes(squares(3), range(4), 2, lost=lambda n, error: (-n, 0)))
    assert sorted(result for result, _ in results) == [-3, 0, 1, 4]
    with pytest.raises(WorkerDiedError, match="episode 3 .* 3 attempts: .* signal 9"):
        list(run_episodes(squares(6), range(4), 2))


@pytest.mark.parametrize("workers", [1, 2])
def test_what_a_worker_or_its_making_raises_is_raised(squares, workers):
    with pytest.raises(BtManipError, match="-1 is negative"):
        list(run_episodes(squares(), [0, -1], workers))
    with pytest.raises(TypeError):
        list(run_episodes(Squares, range(3), workers))


def test_no_process_outlives_the_iteration(squares):
    episodes = run_episodes(squares(), iter(range(1000)), 2)
    processes = {next(episodes)[1] for _ in range(20)}
    episodes.close()
    for process in processes:
        with pytest.raises(ProcessLookupError):
            os.kill(process, 0)


@pytest.mark.parametrize("raised", [EOFError, BlockingIOError])
def test_a_process_that_does_not_start_is_an_error_of_its_own(monkeypatch, raised):
    failing = Mock(side_effect=raised)
    monkeypatch.setattr(multiprocessing.process.BaseProcess, "start", failing)
    with pytest.raises(WorkerDiedError, match="a process did not start: "):
        list(run_episodes(Environment, ["HOME"], workers=2))
    with pytest.raises(WorkerDiedError, match="a process did not start: "):
        call_in_process("the test", confuse)
