"""Run independent episodes in parallel processes, and again where a process died."""

import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext, SpawnContext
from typing import Any, NoReturn, Protocol, TypeVar

from bt_manip.exceptions import BtManipError, reason_of

Episode = TypeVar("Episode")
Result = TypeVar("Result")
E_contra = TypeVar("E_contra", contravariant=True)
R_co = TypeVar("R_co", covariant=True)

EPISODE_ATTEMPTS = 3
"""Number of processes that may die with an episode before it counts as lost."""

BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
"""Environment variables with the number of threads of OpenBLAS, which NumPy's wheels include."""

EXIT_TIME = 5.0
"""Wall time to wait for the exit code of a process that has closed its pipe [s]."""


class WorkerDiedError(BtManipError):
    """The process of an episode died, as by ``kill -9`` or for lack of memory."""


class Worker(Protocol[E_contra, R_co]):
    """Runs episodes in one process, one after the other.

    The result of an episode depends on the episode alone, not on earlier ones.
    """

    def run(self, episode: E_contra, /) -> R_co:
        """Run an episode; both the episode and its result can be pickled."""


class Pool(Protocol):
    """Starts workers in other processes and waits for them.

    A started worker has ``send(episode)``, and ``receive()``, which returns the result, or raises
    `WorkerDiedError` or what the worker raised.
    """

    def start(self) -> Any:
        """Start a worker."""

    def wait(self, workers: Collection[Any]) -> Collection[Any]:
        """Wait until at least one of the busy workers has ended its episode; return these."""

    def close(self) -> None:
        """End all processes at once."""


def raise_lost(episode: object, error: WorkerDiedError) -> NoReturn:
    """Raise the error of an episode whose processes died."""
    raise WorkerDiedError(
        f"episode {episode} was given up after {EPISODE_ATTEMPTS} attempts: {error}"
    )


def run_episodes(
    make_worker: Callable[[], Worker[Episode, Result]],
    episodes: Iterable[Episode],
    workers: int = 1,
    *,
    pool: Pool | None = None,
    lost: Callable[[Episode, WorkerDiedError], Result] = raise_lost,
) -> Iterator[Result]:
    """Run episodes in parallel processes and yield their results in the order of their ends.

    An episode whose process died runs again in a new one, up to `EPISODE_ATTEMPTS` times. When the
    iteration ends early, by Ctrl-C, an exception or ``close()``, the processes are ended at once.
    A worker's process ends when this one does.

    Args:
        make_worker: Makes the worker of a process; it can be pickled.
        episodes: The episodes; taken as they are needed.
        workers: Number of processes; 1: this one, where no pool is given.
        pool: Starts the workers; None: processes of this machine.
        lost: Returns the result of an episode that was given up; by default it raises.

    Raises:
        WorkerDiedError: If an episode was given up.
        Exception: The first exception of a worker.
    """
    if workers == 1 and pool is None:
        yield from map(make_worker().run, episodes)
        return
    pool = pool or ProcessPool(make_worker)
    waiting = iter(episodes)
    again: deque[tuple[Episode, int]] = deque()
    idle: list[Any] = []
    busy: dict[Any, tuple[Episode, int]] = {}
    results: list[Result] = []
    try:
        while True:
            while len(busy) < workers:
                if again:
                    episode, attempt = again.popleft()
                else:
                    try:
                        episode, attempt = next(waiting), 1
                    except StopIteration:
                        break
                worker = idle.pop() if idle else pool.start()
                worker.send(episode)
                busy[worker] = episode, attempt
            yield from results  # while the workers are busy with the next ones
            if not busy:
                return
            results = []
            for worker in pool.wait(busy):
                episode, attempt = busy.pop(worker)
                try:
                    results.append(worker.receive())
                    idle.append(worker)
                except WorkerDiedError as error:
                    if attempt < EPISODE_ATTEMPTS:
                        again.append((episode, attempt + 1))
                    else:
                        results.append(lost(episode, error))
    finally:
        pool.close()


def call_in_process(what: str, function: Callable[[], Result]) -> Result:
    """Call a function in another process, which it may end.

    Args:
        what: What it does, the first words of the error: ``"the first episode"``.
        function: The function; it and its result can be pickled.

    Raises:
        WorkerDiedError: If the process ended.
        Exception: The error of the function.
    """
    process = _Process(_Caller)
    try:
        process.send(function)
        return process.receive()
    except WorkerDiedError as error:
        raise WorkerDiedError(f"{what}: {error}") from None
    finally:
        process.kill()


class _Caller:
    def run(self, function: Callable[[], Any]) -> Any:
        return function()


class ProcessPool:
    """Processes of this machine, each with a pipe of its own, so that one may die alone.

    Attributes:
        cpus: How many workers run at the same time.
    """

    def __init__(self, make_worker: Callable[[], Worker[Any, Any]]) -> None:
        self.cpus = os.cpu_count() or 1
        self._make_worker = make_worker
        self._processes: list[_Process] = []

    def start(self) -> "_Process":
        """Start a process."""
        process = _Process(self._make_worker)
        self._processes.append(process)
        return process

    def wait(self, workers: Collection["_Process"]) -> "Collection[_Process]":
        """Wait for a result or the death of a process."""
        by_pipe = {worker.pipe: worker for worker in workers}
        return [by_pipe[pipe] for pipe in wait(by_pipe) if isinstance(pipe, Connection)]

    def close(self) -> None:
        """Kill the processes."""
        for process in self._processes:
            process.kill()


def _context() -> ForkServerContext | SpawnContext:
    """Return how processes start: forked from one that has imported bt_manip, or each anew.

    This process may have threads, whose locks a fork would copy; one that only imports has none,
    unless OpenGL draws: its library starts threads when it is imported.
    """
    if os.environ.get("MUJOCO_GL") != "disable":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["bt_manip.builtin", "bt_manip.runner"])
    return context


class _Process:
    """A process with a worker, whose BLAS has one thread unless the environment says otherwise."""

    def __init__(self, make_worker: Callable[[], Worker[Any, Any]]) -> None:
        context = _context()
        self.pipe, other = context.Pipe()
        self._process = context.Process(target=_work, args=(make_worker, other), daemon=True)
        resource_tracker.ensure_running()  # `start` would do it, which unblocks SIGINT
        # The process inherits the mask: Ctrl-C reaches this process only, which ends it.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        chosen = any(name in os.environ for name in BLAS_THREADS)
        try:
            if not chosen:  # NumPy reads it when it is imported
                os.environ[BLAS_THREADS[0]] = "1"
            self._process.start()
        except (EOFError, OSError) as error:
            raise WorkerDiedError(f"a process did not start: {reason_of(error)}") from error
        finally:
            if not chosen:
                del os.environ[BLAS_THREADS[0]]
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        other.close()  # the only other end is the process's: its death ends the pipe

    def send(self, episode: Any) -> None:
        with suppress(OSError):  # it is dead, as `receive` will find
            self.pipe.send(episode)

    def receive(self) -> Any:
        try:
            raised, result = self.pipe.recv()
        except (EOFError, OSError):
            self._process.join(EXIT_TIME)
            code = self._process.exitcode or 0
            how = f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
            self.pipe.close()
            raise WorkerDiedError(f"its process {how}") from None
        if raised:
            raise result
        return result

    def kill(self) -> None:
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _work(make_worker: Callable[[], Worker[Any, Any]], pipe: Connection) -> None:
    """Run episodes until the pipe or the parent process ends."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        worker = make_worker()
        while True:
            pipe.send((False, worker.run(pipe.recv())))
    except EOFError:
        return
    except Exception as error:
        pipe.send((True, portable(error)))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def portable(error: Exception) -> Exception:
    """Return an exception that can be pickled, with the traceback as a note."""
    try:
        found = pickle.loads(pickle.dumps(error))
    except Exception:
        if isinstance(error, BtManipError):
            found = BtManipError(str(error))
        else:
            found = RuntimeError(f"{type(error).__name__}: {error}")
    assert isinstance(found, Exception)
    found.add_note("".join(traceback.format_exception(error)))
    return found
