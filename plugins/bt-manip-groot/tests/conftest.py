"""A run that is ticked by the test, with its publisher."""

import os
import threading
from pathlib import Path
from typing import Any

import pytest

from bt_manip import build_station
from bt_manip.bt import Action, BehaviourRegistry, Blackboard, Input, Status, Tree, parse_tree
from bt_manip.runner import Run, RunObserver, RunRequest, Station, TreeSource
from bt_manip_groot.publisher import GrootPublisher
from tests.support.program import bt_manip as bt_manip
from tests.support.program import task as task
from tests.support.runs import make_run as make_run
from tests.support.runs import shared_stations as shared_stations
from tests.support.runs import station_pool as station_pool

from .client import Client, free_ports


class Scripted(Action):
    """Walks a list of outcomes, as the leaf of this name in the engine's sample."""

    outcomes = Input(str, default="S")
    mode = Input(str, default="hold")
    _ticks = 0

    def update(self) -> Status:
        letters = self.outcomes.split(",")
        self._ticks += 1
        last = (self._ticks - 1) % len(letters) if self.mode == "cycle" else -1
        return {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING}[letters[last]]


def sample_tree(document: str) -> Tree:
    """Give the tree of the engine's sample, with the entries that its blackboard begins with."""
    registry = BehaviourRegistry()
    registry.register(Scripted)
    blackboard = Blackboard()
    blackboard["x"], blackboard["name"] = 1, "panda"
    return parse_tree(document, registry, blackboard=blackboard)


@pytest.fixture(scope="session")
def groot2() -> Path:
    """Give the folder with the engine's transcript and log files, or skip the test."""
    root = Path(os.environ.get("BTCPP_ROOT", "shared/btcpp"))
    if not (root / "groot2").is_dir():
        pytest.skip(f"no transcript of BehaviorTree.CPP at {root}")
    return root / "groot2"


@pytest.fixture(scope="session")
def station(parts):
    """Give the station of all runs: each begins a cycle in it."""
    return build_station(parts)


def run_of(station: Station, tree: Tree, **request: Any) -> Run:
    """Give a run of a tree in a station."""
    tree.clock = station.clock
    tree.setup(**station.infrastructure)
    return Run(RunRequest(TreeSource("test", "python"), **request), tree, station)


class Steps(RunObserver):
    """Lets the run go on by one tick at a time."""

    def __init__(self) -> None:
        self._allowed = threading.Semaphore(0)
        self.done = threading.Semaphore(0)
        self.free = False

    def before_tick(self) -> None:
        while not self.free and not self._allowed.acquire(timeout=0.01):
            pass

    def after_tick(self) -> None:
        self.done.release()

    def tick(self, count: int = 1) -> None:
        """Allow ticks and wait for their end."""
        for _ in range(count):
            self.start_tick()
            self.wait()

    def start_tick(self) -> None:
        """Allow a tick that may stop at a breakpoint."""
        self._allowed.release()

    def wait(self) -> None:
        """Wait for the end of a tick."""
        assert self.done.acquire(timeout=20)


class Watched:
    """A run in a thread of its own, its publisher, and a client of that."""

    def __init__(self, station, tree) -> None:
        self.tree = tree
        self.steps = Steps()
        self.lines: list[str] = []
        self.port = free_ports()
        publisher = GrootPublisher(self.port, self.lines.append)
        self.run = run_of(station, tree, cycles=0, tick=0.01)
        self._thread = threading.Thread(
            target=self.run.execute,
            args=[[self.steps, publisher]],
            kwargs={"stop": lambda: self.steps.free},
        )
        self._thread.start()
        self.client = Client(self.port)

    def stop(self) -> None:
        """End the run."""
        self.steps.free = True
        self._thread.join(20)
        assert not self._thread.is_alive()
        self.client.close()


@pytest.fixture
def watch(station):
    """Give a function that starts a run of a tree; it waits for `steps`."""
    started = []

    def start(tree) -> Watched:
        started.append(Watched(station, tree))
        return started[-1]

    yield start
    for one in started:
        one.stop()
