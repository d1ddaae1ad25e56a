"""A station with two robots and a cube between them; reports of registered trees."""

from types import SimpleNamespace

import pytest

from bt_manip import build_station, spatial
from bt_manip.bt import Tree
from bt_manip.record import take_snapshot
from bt_manip.record.report.recorder import Recorder
from bt_manip.record.report.run_report import RunReport
from bt_manip.registry import Parts
from bt_manip.runner import Hardware, Run, RunObserver, prepare, request_of
from bt_manip.scenes import Scene, SceneObject, two_arms
from bt_manip.testing.trial import Trial
from tests.support.program import task as task


@pytest.fixture(scope="module")
def built(parts):
    cube = SceneObject("cube", "cube", spatial.pose((0.0, 0.0, 1.04)), free=True)
    scene = two_arms()
    station = build_station(parts, scene=Scene(scene.robots, (*scene.objects, cube)))
    return station, station.get_state()


@pytest.fixture
def station(built):
    station, start = built
    station.set_state(start)
    return station


@pytest.fixture
def left(station):
    return station.robots["left"]


@pytest.fixture
def right(station):
    return station.robots["right"]


class StillCell:
    """A cell in which nothing happens but time."""

    generation = steps = 0

    def __init__(self) -> None:
        self.before_remove, self.objects, self.entities = [], {}, {}

    @property
    def time(self) -> float:
        return self.steps * 1e-3

    def step(self, n, then=()) -> None:
        for _ in range(n):
            self.steps += 1
            for look in then:
                look()


def still_station() -> SimpleNamespace:
    """Return a station without robots."""
    cell = StillCell()
    return SimpleNamespace(
        cell=cell, robots={}, begin_cycle=lambda cycle: None, hardware=Hardware(cell), files={},
        infrastructure={"cell": cell},
    )  # fmt: skip


def report_of(parts: Parts, tree: str, *observers: RunObserver, **request) -> RunReport:
    recorder = Recorder(tree, request.get("seed", 0))
    prepare(request_of(tree, parts, **request), parts).execute([recorder, *observers])
    return recorder.report()


class Snapshots(RunObserver):
    def run_started(self, run: Run) -> None:
        self.run, self.taken = run, []

    def after_tick(self) -> None:
        self.taken.append(take_snapshot(self.run))


def continued(run: Run, snapshot: dict, **options) -> str:
    """Continue a run from a snapshot; return its digest at the end."""
    recorder = Recorder("", 0)
    run.set_state(snapshot["run"])
    recorder.set_state(snapshot["recorder"])
    run.execute([recorder], **options)
    return recorder.report().state_digest


def set_up(station, root):
    return Trial(station, Tree(root, clock=station.clock))


@pytest.fixture(autouse=True)
def runs_share_stations(shared_stations) -> None:
    """Let runs have the stations of the tests before."""
