"""Runs of trees in stations of their own."""

import importlib
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any

import dm_control.mujoco  # noqa: F401 it reads MUJOCO_GL, which tests change
import pytest

from bt_manip.bt import Node, Tree
from bt_manip.cli import Interrupt, run_app
from bt_manip.registry import Parts
from bt_manip.runner import KINDS, Run, RunEvent, RunObserver, RunRequest, TreeSource
from tests.support.station_pool import StationPool


class Listener(RunObserver):
    """Keeps the events of some kinds, or of all."""

    def __init__(self, events: list[RunEvent], kinds: Collection[str] = KINDS) -> None:
        self.kinds, self._events = kinds, events

    def handle(self, event: RunEvent) -> None:
        self._events.append(event)


PREPARE = importlib.import_module("bt_manip.runner.prepare")  # the name is also a function's
RUNNERS = [
    importlib.import_module(f"bt_manip.{name}")
    for name in ("cli.tracked_episodes", "evaluation.scheduling")
]


@pytest.fixture(scope="session")
def station_pool() -> StationPool:
    return StationPool()


@pytest.fixture
def shared_stations(station_pool: StationPool, monkeypatch) -> Iterator[None]:
    """Let runs have the stations of the tests before: building one takes most of their time."""
    monkeypatch.setattr(PREPARE, "make_station", station_pool.build)
    yield
    station_pool.release()


@pytest.fixture
def in_this_process(monkeypatch) -> None:
    """Let commands run episodes in the process of the test: starting others takes seconds."""

    def run(make_worker, episodes, workers, *, pool, lost) -> Iterator[Any]:
        return map(make_worker().run, episodes)

    monkeypatch.setattr("bt_manip.evaluation.call_in_process", lambda what, function: function())
    for module in RUNNERS:
        monkeypatch.setattr(module, "run_episodes", run)


@pytest.fixture(scope="session")
def make_run(parts: Parts) -> Callable[..., Run]:
    """Make a run of a tree; options that are not named here are those of its request."""

    def make(root: Node, *, goal: Node | tuple[()] = (), **options: Any) -> Run:
        request = RunRequest(TreeSource("test", "python"), **options)
        station = PREPARE.make_station(request, parts)
        tree = Tree(root, clock=station.clock, goal=goal)
        tree.setup(**station.infrastructure)
        return Run(request, tree, station)

    return make


@pytest.fixture(scope="session")
def picked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record two cycles of pick_place once, with the report beside the recording."""
    path = tmp_path_factory.mktemp("picked") / "run.mcap"
    command = ["run", "pick_place", "--cycles", "2", "--quiet", "--record", str(path)]
    assert run_app(Interrupt(), [*command, "--report", str(path.with_suffix(".json"))]) == 0
    return path
