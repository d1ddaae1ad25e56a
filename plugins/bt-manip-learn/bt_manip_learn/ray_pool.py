"""Workers on a cluster of Ray: of this machine, or of many."""

import importlib.util
import ipaddress
import logging
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

from bt_manip.evaluation import Worker, WorkerDiedError, portable
from bt_manip.exceptions import BtManipError

LOCAL = "local"
"""Address that stands for a cluster of this machine, which is started and ended with the pool."""

OBJECT_STORE = 100 * 2**20
"""Shared memory of a local cluster, the least that Ray accepts [bytes]; results do not use it."""

AUTO = "auto"
"""Address that stands for the one in ``RAY_ADDRESS``, or else the last ``ray start`` here."""

CONNECTION_TIME = 20.0
"""Wall time to wait for a connection to a cluster [s]."""

_CONNECT = """
import os, sys, ray
try:
    ray.init(sys.argv[1], logging_level="ERROR", log_to_driver=False)
except Exception as error:
    sys.exit(f"{error}".splitlines()[0])
os._exit(0)
"""


class RayPool:
    """Workers as actors of a Ray cluster, each with one CPU.

    A local cluster listens on the loopback interface only, and has no dashboard.

    Args:
        make_worker: Makes the worker of an actor; it can be pickled.
        address: ``HOST:PORT`` of the cluster, `AUTO` or `LOCAL`.
        workers: Number of CPUs of a local cluster; 0: all of this machine.

    Attributes:
        cpus: Number of CPUs of the cluster: how many workers run at the same time.

    Raises:
        BtManipError: If Ray is missing, or there is no cluster at the address.
    """

    def __init__(
        self, make_worker: Callable[[], Worker[Any, Any]], address: str = LOCAL, workers: int = 0
    ) -> None:
        if importlib.util.find_spec("ray") is None:
            raise BtManipError("--ray needs Ray: pip install './plugins/bt-manip-learn[ray]'")
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        if address == LOCAL:  # without it, the servers of the cluster listen everywhere
            os.environ[_LOOPBACK_ONLY] = "0"
        else:
            address = _reachable(address)
        import ray

        self._ray, self._make_worker = ray, make_worker
        options: dict[str, Any] = {"address": address, "log_to_driver": False}
        if address == LOCAL:
            options |= {"num_cpus": workers or os.cpu_count(), "object_store_memory": OBJECT_STORE}
            options["include_dashboard"] = False
        try:
            ray.init(logging_level=logging.ERROR, **options)
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise BtManipError(f"--ray {address}: {str(error).splitlines()[0]}") from error
        self.cpus = max(1, int(ray.cluster_resources().get("CPU", 1)))

    def start(self) -> "_Actor":
        """Start an actor."""
        return _Actor(self._ray, self._make_worker)

    def wait(self, workers: "Collection[_Actor]") -> "Collection[_Actor]":
        """Wait for a result or the death of an actor."""
        by_result = {worker.result: worker for worker in workers}
        self._ray.wait(list(by_result))
        ready, _ = self._ray.wait(list(by_result), num_returns=len(by_result), timeout=0)
        return [by_result[result] for result in ready]

    def close(self) -> None:
        """End the actors, and a local cluster."""
        self._ray.shutdown()


_LOOPBACK_ONLY = "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"
"""Variable that Ray reads at its import; "0" keeps it to the loopback interface."""


def _reachable(address: str) -> str:
    """Return ``HOST:PORT`` of a cluster after a connection to it, at most `CONNECTION_TIME` later.

    Ray replaces the loopback address by that of the machine, where a cluster on the loopback
    interface does not listen, unless it is told to keep to that interface.
    """
    end = time.monotonic() + CONNECTION_TIME
    if address == AUTO:
        address = os.environ.get("RAY_ADDRESS") or _last_started()
    host, colon, port = address.rpartition(":")
    if not colon or not port.isdecimal() or not 0 < int(port) < 2**16 or "/" in host:
        raise BtManipError(
            f"--ray is HOST:PORT, such as 127.0.0.1:6379, or {AUTO}, got '{address}'"
        )
    try:
        with socket.create_connection((host.strip("[]"), int(port)), CONNECTION_TIME) as server:
            peer = ipaddress.ip_address(server.getpeername()[0])
    except OSError as error:
        raise BtManipError(f"--ray {address}: there is no cluster at HOST:PORT: {error}") from None
    if peer.is_loopback:
        os.environ[_LOOPBACK_ONLY] = "0"
    _connect(address, max(end - time.monotonic(), 1.0))
    return address


def _last_started() -> str:
    """Return the address of the last ``ray start`` on this machine, from a file of Ray."""
    folder = os.environ.get("RAY_TMPDIR") or os.environ.get("TMPDIR") or "/tmp"
    try:
        return Path(folder, "ray", "ray_current_cluster").read_text().strip()
    except OSError:
        raise BtManipError(
            f"--ray {AUTO}: RAY_ADDRESS is not set, and no cluster was started here by 'ray start'"
        ) from None


def _connect(address: str, timeout: float) -> None:
    """Connect in a process of its own: Ray waits for minutes, and ignores Ctrl-C meanwhile."""
    command = [sys.executable, "-c", _CONNECT, address]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        reason = f"no cluster answered within {CONNECTION_TIME:g} s"
    else:
        if done.returncode == 0:
            return
        reason = (done.stderr.strip().splitlines() or ["Ray ended"])[-1]
    raise BtManipError(f"--ray {address}: {reason}")


class _Actor:
    """A worker in an actor.

    Attributes:
        result: Ray's reference of the result of the present episode.
    """

    def __init__(self, ray: Any, make_worker: Callable[[], Worker[Any, Any]]) -> None:
        self._ray: Any = ray
        self.result: Any = None
        self._actor = ray.remote(num_cpus=1)(_RemoteWorker).remote(make_worker)

    def send(self, episode: Any) -> None:
        self.result = self._actor.run.remote(episode)

    def receive(self) -> Any:
        errors = self._ray.exceptions
        try:
            raised, result = self._ray.get(self.result)
        except (errors.RayActorError, errors.OutOfMemoryError, errors.ObjectLostError) as error:
            raise WorkerDiedError(f"its actor died: {str(error).splitlines()[0]}") from None
        if raised:
            raise result
        return result


class _RemoteWorker:
    """Actor that runs episodes; the first one makes the worker, so that its errors are returned."""

    def __init__(self, make_worker: Callable[[], Worker[Any, Any]]) -> None:
        self._make_worker = make_worker
        self._worker: Worker[Any, Any] | None = None

    def run(self, episode: Any) -> tuple[bool, Any]:
        try:
            if self._worker is None:
                self._worker = self._make_worker()
            return False, self._worker.run(episode)
        except Exception as error:
            return True, portable(error)
