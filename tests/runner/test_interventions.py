"""Interventions from outside, reproducibly: Perturbations pull bodies, overrides set statuses."""

import json

import mujoco
import numpy as np
import pytest

from bt_manip.bt import (
    AlwaysSuccess,
    Fallback,
    NodeStatus,
    RetryUntilSuccessful,
    Sequence,
    Sleep,
    Tree,
)
from bt_manip.exceptions import BtManipError
from bt_manip.record import Recorder
from bt_manip.runner import Run, RunObserver, RunRequest, TreeSource
from bt_manip_recording import log_line
from tests.support.runs import Listener

START = np.array([0.0, 0.0, 1.04])


def pull(target, body="cube", point=(0.0, 0.0, 0.0), max_force=50.0):
    return {
        "kind": "perturbation", "body": body, "point": [*point], "target": target,
        "max_force": max_force,
    }  # fmt: skip


def override(path, status="FAILURE", before=True, execution=0):
    return {
        "kind": "override", "path": path, "before": before, "status": status,
        "execution": execution,
    }  # fmt: skip


class Outcome(RunObserver):
    """Runs a tree, makes requests at their times, and keeps events and states."""

    def __init__(self, station, root, requests=(), state=None) -> None:
        tree = Tree(root, clock=station.clock)
        tree.setup(**station.infrastructure)
        self.run = Run(RunRequest(TreeSource("test", "python")), tree, station)
        self.requests, self.states = requests, []
        if state is not None:
            self.run.set_state(state)
        recorder, self.events = Recorder("test", 0), []
        self.run.execute([recorder, Listener(self.events), self])
        self.digest = recorder.report().state_digest
        self.position = station.cell.pose("cube").translation

    def before_tick(self):
        for time, data in self.requests:
            if time == pytest.approx(self.run.station.cell.time):
                self.run.interventions.request(data)

    def after_tick(self):
        self.states.append(self.run.get_state())

    def interventions(self):
        return [(e.time, e.data) for e in self.events if e.kind == "intervention"]


@pytest.fixture
def start(station):
    """Give a function that runs a tree from the same initial state each time."""
    initial = station.get_state()

    def run(root, requests=(), state=None) -> Outcome:
        station.set_state(initial)
        return Outcome(station, root, requests, state)

    return run


def rest(msec=300):
    return Sequence("root", Sleep("rest", msec=msec))


def test_a_pulled_object_moves_towards_the_target_until_it_is_let_go(start):
    target = [0.0, 0.1, 1.25]
    held = start(rest(), [(0.0, pull(target))])
    assert np.linalg.norm(held.position - target) < 0.6 * np.linalg.norm(START - target)
    let_go = start(rest(), [(0.0, pull(target)), (0.02, pull(None))])
    assert let_go.position[2] < 1.1
    assert [d["begins"] for _, d in let_go.interventions()] == [True, False]


def test_the_force_is_that_of_mujocos_window_up_to_its_limit(station):
    run = Outcome(station, rest(10), [(0.0, pull([0.0, 0.0, 1.3]))]).run
    cell, body = station.cell, station.cell.body_id("cube")
    for limit in (1e3, 0.5):
        run.interventions.pull("cube", [0.0, 0.0, 1.3], point=(0.01, 0, 0), max_force=limit)
        run.interventions.take_over()
        run.interventions.perturbations.apply()
        spring, scene = mujoco.MjvPerturb(), mujoco.MjvScene(cell.model, maxgeom=1)
        spring.select, spring.active = body, int(mujoco.mjtPertBit.mjPERT_TRANSLATE)
        spring.localpos = [0.01, 0, 0]
        for camera in scene.camera:
            camera.forward, camera.up, camera.frustum_near = (0, 1, 0), (0, 0, 1), 0.1
        mujoco.mjv_initPerturb(cell.model, cell.data, scene, spring)
        spring.refselpos = [0.0, 0.0, 1.3]
        wrench = cell.data.xfrc_applied[body].copy()
        mujoco.mjv_applyPerturbForce(cell.model, cell.data, spring)
        expected = cell.data.xfrc_applied[body]
        scale = min(1.0, limit / np.linalg.norm(expected[:3]))
        assert wrench == pytest.approx(scale * expected, rel=1e-9)
        run.interventions.clear()
        assert not cell.data.xfrc_applied.any()


def test_reported_interventions_requested_again_give_the_same_states(start):
    root = lambda: Fallback(  # noqa: E731
        "root", RetryUntilSuccessful("retry", Sleep("rest", msec=30), num_attempts=4)
    )
    requests = [
        (0.02, pull([0.1, 0.1, 1.3])),
        (0.05, pull([0.2, 0.0, 1.3], point=(0.01, 0.0, 0.0))),
        (0.06, override("rest")),
        (0.07, override("rest", before=False)),
        (0.09, pull(None)),
    ]
    first = start(root(), requests)
    plain = json.loads(json.dumps(first.interventions()))
    assert start(root(), plain).digest == first.digest != (without := start(root()).digest)
    assert start(root(), [(0.1, pull(None))]).digest == without


def test_a_snapshot_taken_during_a_pull_continues_bit_for_bit(start):
    whole = start(rest(100), [(0.02, pull([0.1, 0.1, 1.3]))])
    state = json.loads(json.dumps(whole.states[4]))
    again = start(rest(100), state=state)
    assert json.dumps(again.states[-1]["station"]) == json.dumps(whole.states[-1]["station"])
    assert state["interventions"]["perturbations"][0]["body"] == "cube"


def test_of_several_requests_before_a_tick_the_last_target_counts_and_the_log_has_one_line(start):
    requests = [(0.0, pull([0.0, y, 1.2])) for y in (0.1, 0.2, 0.3)]
    requests.append((0.05, override("rest")))
    found = start(rest(), requests)
    pulls = [data["target"] for _, data in found.interventions() if "target" in data]
    assert pulls == [[0.0, 0.3, 1.2], None]  # it ends with the run
    lines = [line[1] for e in found.events if e.kind == "intervention" and (line := log_line(e))]
    assert lines == ["cube is pulled", "rest: its status was set to FAILURE", "cube is let go"]


def test_a_pull_ends_when_its_object_is_removed(station):
    run = Outcome(station, rest(10)).run
    found = []
    run.interventions.observers.append(found.append)
    run.interventions.pull("cube", [0.0, 0.0, 1.3])
    run.interventions.take_over()
    station.cell.remove("cube")
    run.interventions.perturbations.apply()
    assert not run.interventions.perturbations.active
    assert [one["target"] for one in found] == [[0.0, 0.0, 1.3], None]
    run.interventions.request(pull(None))
    run.interventions.take_over()
    assert len(found) == 2


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (pull([0, 0, 1], body="cub"), "no body or entity is called 'cub'"),
        (pull([0, 0, 1], body="left/hand"), "part of a robot"),
        (pull([0, 0, 1], body="table"), "it is fixed"),
        (pull([0, 0, float("nan")]), "two points and a force"),
        (pull([0, 0, 1], max_force=-1.0), "two points and a force"),
        (override("nothing"), "no node 'nothing'"),
        (override("rest", status="RUNNING"), "SUCCESS or FAILURE"),
    ],
)
def test_impossible_requests_raise_at_once(station, data, message):
    run = Outcome(station, rest(10)).run
    with pytest.raises(BtManipError, match=message):
        run.interventions.request(data)


def test_a_point_without_mobility_is_pulled_with_at_most_the_limit(station, monkeypatch):
    run = Outcome(station, rest(10)).run
    monkeypatch.setattr(mujoco, "mj_jac", lambda *_: None)  # as on the axis of a hinge
    run.interventions.pull("cube", [0.0, 0.0, 1.3], max_force=2.0)
    run.interventions.take_over()
    run.interventions.perturbations.apply()
    force = station.cell.data.xfrc_applied[station.cell.body_id("cube")][:3]
    assert np.linalg.norm(force) == pytest.approx(2.0)
    run.interventions.clear()


@pytest.mark.parametrize("before", [True, False])
def test_an_override_replaces_the_status_of_one_tick(start, before):
    root = Sequence("root", Sleep("rest", msec=100), AlwaysSuccess("next"))
    found = start(root, [(0.03, override("rest", "SUCCESS", before))])
    assert round(found.events[-1].time, 6) == 0.04
    ((time, data),) = found.interventions()
    assert (round(time, 6), data["path"], data["status"]) == (0.03, "rest", "SUCCESS")


def test_an_override_counts_the_executions_of_its_node_in_the_tick(start):
    root = RetryUntilSuccessful("root", AlwaysSuccess("leaf"), num_attempts=5)
    requests = [(0.0, override("leaf", execution=n)) for n in (0, 1, 2)]
    found = start(root, requests).interventions()
    assert [(d["execution"], d["status"]) for _, d in found] == [(0, "FAILURE")]


def test_hooks_of_several_owners_share_a_node(station):
    run = Outcome(station, rest(10)).run
    node, seen = run.tree.node("rest"), []
    run.interventions.set_tick_hooks("a", node, lambda n: seen.append("a"), None)
    run.interventions.set_tick_hooks("b", node, lambda n: NodeStatus.SUCCESS, None)
    run.interventions.set_tick_hooks("c", node, lambda n: seen.append("c"), None)
    assert run.tree.tick_exactly_once() is NodeStatus.SUCCESS
    assert seen == ["a"]
    run.interventions.set_tick_hooks("b", node, None, None)
    assert run.tree.tick_exactly_once() is NodeStatus.RUNNING
    assert seen == ["a", "a", "c"]
    run.tree.halt()
