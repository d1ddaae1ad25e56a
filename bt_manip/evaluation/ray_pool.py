"""Workers on a cluster of Ray: of this machine, or of many."""

import logging
import os
import socket
from collections.abc import Callable, Collection
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.extras import require_extra

from .engine import Worker, WorkerDiedError, portable

LOCAL = "local"
"""Address that stands for a cluster of this machine, which is started and ended with the pool."""

OBJECT_STORE = 100 * 2**20
"""Shared memory of a local cluster, the least that Ray accepts [bytes]; results do not use it."""

CONNECTION_TIME = 10.0
"""Wall time to wait for a connection to a cluster [s]."""


class RayPool:
    """Workers as actors of a Ray cluster, each with one CPU.

    A local cluster listens on the loopback interface only, and has no dashboard.

    Attributes:
        cpus: Number of CPUs of the cluster: how many workers run at the same time.
    """

    def __init__(
        self, make_worker: Callable[[], Worker[Any, Any]], address: str = LOCAL, workers: int = 0
    ) -> None:
        """Connect to a cluster, or start one.

        Args:
            make_worker: Makes the worker of an actor; it can be pickled.
            address: ``HOST:PORT`` of the cluster, or `LOCAL`.
            workers: Number of CPUs of a local cluster; 0: all of this machine.

        Raises:
            BtManipError: If Ray is missing, or there is no cluster at the address.
        """
        require_extra("ray", "--ray", "ray")
        if address == LOCAL:  # before Ray is imported; without it, its servers listen everywhere
            os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"
        else:
            _require_server(address)  # Ray would try for minutes
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
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


def _require_server(address: str) -> None:
    """Check that something listens at ``HOST:PORT``."""
    host, _, port = address.rpartition(":")
    try:
        socket.create_connection((host, int(port)), timeout=CONNECTION_TIME).close()
    except (OSError, ValueError, OverflowError) as error:
        raise BtManipError(f"--ray {address}: there is no cluster at HOST:PORT: {error}") from None


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
    """What runs in an actor; the worker is made with the first episode, so that errors return."""

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
