"""Policies in their own process, with limits of time and memory."""

import json
import os
import signal
import subprocess
import sys
import weakref
from collections.abc import Callable, Mapping
from multiprocessing import Pipe
from multiprocessing.connection import Connection

import numpy as np

from bt_manip.control import ControlError
from bt_manip.exceptions import did_you_mean, shown

from .policy_kind import ONNX, PolicyKind
from .worker import MAX_REPLY

START_TIME = 60.0
"""Timeout for the start of the process and the import of a policy's class, in wall time [s]."""

_COMMAND = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from bt_manip_policy.worker import main
main(int(sys.argv[2]), int(sys.argv[3]))
"""


class PolicyError(ControlError):
    """A policy cannot be loaded, does not fit the station, or returns no valid action."""


class PolicyProcess:
    """Loads and runs policies in a separate process, to protect this one.

    The process starts on demand, also after it was killed. It ends with this object, with this
    process, and with its pipe, so that it does not survive a crash.

    Args:
        memory: Limit of the data of the process [bytes].
    """

    def __init__(self, memory: int = ONNX.memory) -> None:
        self._memory = memory
        self._end: Callable[[], object] = lambda: None
        self._process: subprocess.Popen[bytes] | None = None
        self._pipe: Connection | None = None
        self._loaded: set[tuple[str, str]] = set()

    @property
    def pid(self) -> int | None:
        """Number of the process; None where none runs."""
        return None if self._process is None else self._process.pid

    def answer(
        self,
        make: str,
        path: str,
        observations: Mapping[str, np.ndarray] | None,
        limit: float,
    ) -> bytes:
        """Return the reply of a policy to observations; with None, load it again.

        A policy is also loaded with the first observations, and after the process was killed.

        Args:
            make: Factory of the policy, see `PolicyKind.make`.
            path: File of the policy.
            observations: The present observations by name.
            limit: Timeout in wall time [s].

        Raises:
            PolicyError: If there is no reply within the limits.
        """
        key = make, path
        try:
            if observations is None or key not in self._loaded:
                self._loaded.discard(key)
                self._started().send((limit, key, None))
                self._receive(START_TIME)
                reply = self._receive(limit)
                self._loaded.add(key)
            if observations is not None:
                self._started().send((limit, key, observations))
                reply = self._receive(limit)
            return reply
        except PolicyError as error:
            raise PolicyError(f"policy '{path}' {error}") from None
        except (EOFError, OSError) as error:
            reason = self._reason(error, limit)
            self.close()
            raise PolicyError(f"policy '{path}' {reason}") from error
        except BaseException:  # Ctrl-C
            self.close()
            raise

    def close(self) -> None:
        """Kill the process; a new one is started on demand."""
        self._end()
        self._process = self._pipe = None
        self._loaded.clear()

    def _started(self) -> Connection:
        if self._pipe is None:
            self._pipe, other = Pipe()
            with other:
                environment = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ}
                arguments = json.dumps(sys.path), str(other.fileno()), str(self._memory)
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-c", _COMMAND, *arguments], pass_fds=[other.fileno()],
                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                    env=environment, process_group=0,  # Ctrl-C reaches this process only
                )  # fmt: skip
            self._end = weakref.finalize(self, _kill, self._process, self._pipe)
        return self._pipe

    def _receive(self, limit: float) -> bytes:
        """Return a reply.

        Raises:
            PolicyError: If the policy has a problem.
            EOFError: If the process has ended; also other types of `OSError`.
            TimeoutError: If the process does not respond, although it should have ended.
        """
        assert self._pipe is not None
        if not self._pipe.poll(limit + 1.0):
            raise TimeoutError
        reply = self._pipe.recv_bytes(MAX_REPLY)
        if reply.startswith(b'{"problem"'):
            raise PolicyError(json.loads(reply)["problem"])
        return reply

    def _reason(self, error: Exception, limit: float) -> str:
        """Return the reason of a missing reply."""
        assert self._process is not None
        try:
            code = self._process.wait(0.0 if isinstance(error, TimeoutError) else 1.0)
        except subprocess.TimeoutExpired:
            return "does not answer"
        if code == -signal.SIGALRM:
            return f"takes longer than {limit:g} s"
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return f"ended its process ({how})"


class LoadedPolicy:
    """A policy in a separate process.

    Args:
        process: The process.
        kind: Its kind.
        path: Its file, the argument of `PolicyKind.make`.

    Attributes:
        path: Its file.
        action: Kind of the actions.
        rate: Number of actions per second [Hz].
        inputs: Shape of each observation; None for a dimension of any size.
        states: Shape of each recurrent state.
        history: Number of successive observations in an input, the present one last.
        execute: Number of executed rows of an output before the next observation; 0: all.
        ensemble: Decay of temporal ensembling; None without it.

    Raises:
        PolicyError: If it cannot be created within the limits.
    """

    def __init__(self, process: PolicyProcess, kind: PolicyKind, path: str) -> None:
        self._process, self._kind, self.path = process, kind, path
        about = json.loads(process.answer(kind.make, path, None, kind.load_time))
        self.action: str = about["action"]
        self.rate: float = about["rate"]
        self.inputs = {name: tuple(shape) for name, shape in about["inputs"].items()}
        self.states = {name: tuple(shape) for name, shape in about["states"].items()}
        self.history: int = about["history"]
        self.execute: int = about["execute"]
        self.ensemble: float | None = about["ensemble"]

    def check(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Check that it fits a station.

        Args:
            shapes: Shapes of the station's observations by name.

        Raises:
            PolicyError: If the policy requires others.
        """
        for name, expected in self.inputs.items():
            if name not in shapes:
                raise self.error(
                    f"expects the observation {shown(name)}, which the station lacks"
                    + did_you_mean(name, shapes)
                )
            found = shapes[name] if self.history == 1 else (self.history, *shapes[name])
            if not (_fits(found, expected) or _fits((1, *found), expected)):
                raise self.error(
                    f"expects the observation {shown(name)} of size {_shape_text(expected)}, the "
                    f"station's has {_shape_text(found)}"
                )

    def act(
        self,
        observations: Mapping[str, np.ndarray],
        size: int,
        states: Mapping[str, np.ndarray] | None = None,
        *,
        trial: bool = False,
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the next actions, one per row, and the next recurrent states.

        Args:
            observations: The present observations by name.
            size: Number of values of an action.
            states: The recurrent states by name; none: zeros.
            trial: Whether the observations are placeholders: the actions need not be finite, and
                the timeout is `PolicyKind.load_time`.

        Raises:
            PolicyError: If the policy fails, or its result is not finite or has another shape.
        """
        wanted = {name: observations[name] for name in self.inputs}
        wanted |= states or {name: np.zeros(shape) for name, shape in self.states.items()}
        limit = self._kind.load_time if trial else self._kind.time
        reply = self._process.answer(self._kind.make, self.path, wanted, limit)
        head, _, data = reply.partition(b"\n")
        described, numbers = json.loads(head), np.frombuffer(data)
        if set(described["states"]) != set(self.states):
            raise self.error("returned other states than it expects")
        after = {name: self.states[name] for name in described["states"]}
        sizes = [int(np.prod(shape, dtype=int)) for shape in (described["shape"], *after.values())]
        if sum(sizes) != numbers.size:
            raise self.error("returned states of other sizes than it expects")
        actions, *rest = np.split(numbers, np.cumsum(sizes)[:-1])
        actions = actions.reshape(described["shape"])
        if actions.ndim == 3 and len(actions) == 1:
            actions = actions[0]
        actions = np.atleast_2d(actions)
        if actions.ndim != 2 or not len(actions) or actions.shape[1] != size:
            raise self.error(
                f"returned values of shape {_shape_text(described['shape'])}, an action "
                f"'{self.action}' of this robot has {size}"
            )
        if not trial and not np.isfinite(numbers).all():
            raise self.error(f"returned an action that is not finite: {actions.tolist()[0]}")
        pairs = zip(after.items(), rest, strict=True)
        return actions, {name: values.reshape(shape) for (name, shape), values in pairs}

    def error(self, message: str) -> PolicyError:
        """Return an error with the policy's name."""
        return PolicyError(f"policy '{self.path}' {message}")


def shared_process(memory: int) -> PolicyProcess:
    """Return the process shared by all policies with a memory limit; it ends with the last."""
    return _processes.setdefault(memory, PolicyProcess(memory))


_processes: weakref.WeakValueDictionary[int, PolicyProcess] = weakref.WeakValueDictionary()


def _kill(process: subprocess.Popen[bytes], pipe: Connection) -> None:
    pipe.close()
    process.kill()
    process.wait()


def _fits(shape: tuple[int, ...], expected: tuple[int | None, ...]) -> bool:
    return len(shape) == len(expected) and all(
        e in (None, n) for n, e in zip(shape, expected, strict=True)
    )


def _shape_text(shape: tuple[int | None, ...]) -> str:
    return " x ".join("any" if n is None else str(n) for n in shape) or "none"
