"""A recorded run goes on from any of its moments and ends in the same state, bit for bit."""

import json
from dataclasses import replace

import pytest

from bt_manip import spatial
from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import Fallback, NodeStatus, Sequence, Sleep
from bt_manip.exceptions import BtManipError
from bt_manip.record import Recorder, restore_snapshot
from bt_manip.runner import RunObserver
from bt_manip.scenes import SceneObject, table_and_basket
from bt_manip_recording import (
    Continuation,
    McapRecorder,
    RecordedInterventions,
    Recording,
    mcap_recorder,
)
from bt_manip_recording.mcap_recorder import SNAPSHOTS

REQUEST = {"cycles": 3, "seed": 5}


def tree():
    return Sequence(
        "root",
        SpawnObject("spawn", object="{spawned}"),
        Fallback("try", Sleep("first", msec=50), Sleep("second", msec=30)),
        MoveToConfiguration("move", configuration=[0.1, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        RemoveObject("remove", object="{spawned}"),
    )


class Intervene(RunObserver):
    """Pulls a cube until the second cycle, in which it lets a node fail."""

    def run_started(self, run):
        self.run, self.ticks = run, 0

    def before_tick(self):
        requests, self.ticks = self.run.interventions, self.ticks + 1
        if 3 <= self.ticks < 31:
            requests.pull("red", [0.5, 0.3, 1.2 + 1e-3 * self.ticks], point=(0.01, 0.0, 0.0))
        elif self.ticks == 31:
            requests.pull("red", None)
        if self.run.cycle == 1 and self.run.tree.node("first").engine_status is NodeStatus.RUNNING:
            requests.override("first", NodeStatus.FAILURE)


@pytest.fixture(scope="module")
def scene():
    plain = table_and_basket()
    red = SceneObject("cube", "red", spatial.pose((0.6, -0.25, 1.05)), free=True)
    return replace(plain, objects=(*plain.objects, red))


@pytest.fixture(scope="module")
def recorded(make_run, scene, tmp_path_factory):
    """Record a run with interventions; give the file and the digest of the run."""
    path = tmp_path_factory.mktemp("recorded") / "run.mcap"
    recorder = Recorder("test", 5)
    run = make_run(tree(), scene=scene, **REQUEST)
    run.execute([recorder, McapRecorder(path), Intervene()])
    return path, recorder.report()


@pytest.fixture(scope="module")
def run(make_run, scene):
    """Give a run of the recorded request; each test restores the state that it needs."""
    return make_run(tree(), scene=scene, **REQUEST)


@pytest.mark.parametrize("share", [0.0, 0.002, 0.3, 0.7, 1.0])
def test_it_ends_in_the_recorded_state_from_every_moment(run, recorded, share):
    path, report = recorded
    moment = share * report.simulated_s
    continued = Continuation(Recording(path), moment)
    snapshot = json.loads(json.dumps(continued.simulate(run)))
    recorder = Recorder("test", 5)
    restore_snapshot("", snapshot, run, recorder)
    begins = run.station.cell.time
    run.execute([recorder, RecordedInterventions(continued.recording)])
    assert recorder.report().state_digest == report.state_digest
    assert 0.0 <= begins - moment < run.request.tick + 1e-9


def test_snapshots_are_at_the_start_after_each_cycle_and_in_between(
    make_run, tmp_path, monkeypatch
):
    monkeypatch.setattr(mcap_recorder, "SNAPSHOT_INTERVAL", 0.05)
    path = tmp_path / "run.mcap"
    run = make_run(Sequence("root", Sleep("rest", msec=115)), cycles=2)
    run.execute([McapRecorder(path)])
    times = [time for time, _, _ in Recording(path).messages(SNAPSHOTS)]
    assert times == pytest.approx([0.0, 0.05, 0.1, 0.13, 0.18, 0.23, 0.26])


def test_no_snapshot_is_taken_of_a_tree_that_was_interrupted(make_run, tmp_path, monkeypatch):
    path = tmp_path / "run.mcap"
    slow = {"configuration": [0.9, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]}
    run = make_run(MoveToConfiguration("move", **slow))
    monkeypatch.setattr(mcap_recorder, "SNAPSHOT_INTERVAL", 0.0)  # one is due at every tick
    run.execute([McapRecorder(path)], stop=lambda: run.station.cell.time > 0.2)
    *_, (last, _, data) = Recording(path).messages(SNAPSHOTS)
    assert last < run.station.cell.time - 0.05
    assert data["run"]["tree"] is not None


@pytest.mark.parametrize(
    ("moment", "message"), [(-1.0, "no snapshot at or before -1 s"), (99.0, "ends at .* before 99")]
)
def test_moments_that_were_not_recorded_are_refused(recorded, moment, message):
    with pytest.raises(BtManipError, match=message):
        Continuation(Recording(recorded[0]), moment)


def test_a_changed_file_is_refused_and_other_versions_are_warnings(run, recorded):
    path, _ = recorded
    continued = Continuation(Recording(path), 0.1)
    assert continued.differences(run) == []
    identity = continued.recording.identity
    identity["versions"] = {**identity["versions"], "mujoco": "2.0"}
    (line,) = continued.differences(run)
    assert line.startswith("recorded with mujoco 2.0, here ")
    identity["sha256"] = {**identity["sha256"], "panda.xml": "0"}
    with pytest.raises(BtManipError, match="cannot be continued: panda.xml differs"):
        continued.differences(run)


def test_the_request_is_the_recorded_one(recorded, tmp_path):
    file = tmp_path / "trees.py"
    file.write_text("")
    continued = Continuation(Recording(recorded[0]), 0.1)
    request = continued.request({"test": f"{file}:tree"}, real_time=2.0)
    assert (request.seed, request.cycles, request.real_time) == (5, 3, 2.0)
    with pytest.raises(BtManipError, match="unknown tree 'test'"):
        continued.request({})
