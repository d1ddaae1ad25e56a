"""Breakpoints pause simulated time, and hooks replace the statuses of nodes."""

import json
import time
from unittest.mock import Mock

import pytest
from py_trees.behaviours import Running

from bt_manip.behaviours import MoveHome, MoveToConfiguration
from bt_manip.bt import Action, AlwaysSuccess, Fallback, Sequence, Sleep, Status, Tree
from bt_manip_groot import publisher as publisher_module

from .client import hook, unlock

IDLE, RUNNING, SUCCESS, FAILURE = range(4)


class Count(Action):
    """Counts how often it is ticked and halted."""

    ticks = halts = 0

    def update(self):
        self.ticks += 1
        return Status.RUNNING

    def terminate(self, new_status):
        self.halts += new_status is Status.INVALID


@pytest.fixture
def counted(watch):
    """Give a run of two leaves below a Sequence, uids 2 and 3."""
    count = Count()
    watched = watch(Tree(Sequence(AlwaysSuccess(), count)))
    watched.count = count
    return watched


def test_a_breakpoint_pauses_simulated_time_before_its_node(counted):
    client, steps = counted.client, counted.steps
    steps.tick()
    client.ask("I", hook(3))
    paused_at = counted.run.station.cell.time
    steps.start_tick()
    assert client.reached() == 3
    time.sleep(0.2)
    assert counted.run.station.cell.time == paused_at
    assert counted.count.ticks == 1
    assert counted.lines == ["Paused at a breakpoint of Groot2: Count::3"]
    client.ask("U", unlock(3))
    steps.wait()
    assert counted.count.ticks == 2
    assert client.hooks() == [hook(3)]


@pytest.mark.parametrize("release", ["A", "X", "R", "I"])
def test_a_run_goes_on_when_its_breakpoint_is_removed_or_disabled(counted, release):
    client, steps = counted.client, counted.steps
    client.ask("I", hook(3))
    steps.start_tick()
    client.reached()
    payload = {"R": unlock(3), "I": hook(3, enabled=False)}.get(release)
    client.ask(release, payload)
    steps.wait()
    assert counted.count.ticks == 1
    steps.tick()
    assert counted.count.ticks == 2


def test_a_paused_run_goes_on_when_groot2_is_gone(counted, monkeypatch):
    monkeypatch.setattr(publisher_module, "HEARTBEAT", 1.0)
    client, steps = counted.client, counted.steps
    client.ask("I", hook(3))
    steps.start_tick()
    client.reached()
    steps.wait()
    assert client.hooks() == [hook(3)]  # and with this request it is back
    steps.start_tick()
    assert client.reached() == 3
    steps.wait()


def test_a_replaced_node_is_not_ticked(watch):
    count = Count()
    watched = watch(Tree(Fallback(Sequence(count), Sleep(msec=1000))))
    client, steps = watched.client, watched.steps
    client.ask("I", [hook(3, "FAILURE", mode=1)])
    steps.tick(2)
    assert count.ticks == 0
    assert client.statuses() == {1: RUNNING, 2: FAILURE, 3: 10 + FAILURE, 4: RUNNING}
    client.ask("R", unlock(3))
    assert client.hooks() == []


def test_a_hook_after_a_node_replaces_its_result(watch):
    watched = watch(Tree(Sequence(AlwaysSuccess(), Sleep(msec=1000))))
    watched.client.ask("I", hook(2, "FAILURE", mode=1, position=1, once=True))
    watched.steps.tick()
    assert watched.client.statuses()[1] == 10 + FAILURE
    assert watched.client.hooks() == []
    assert watched.tree.failure_reason() == "AlwaysSuccess::2: a hook replaced its status"
    watched.steps.tick()
    assert watched.client.statuses()[1] == RUNNING


def test_replacing_the_status_of_a_motion_stops_the_arm(watch):
    move = MoveToConfiguration(configuration=[0.5, -0.5, 0.0, -2.0, 0.0, 1.6, 0.8])
    watched = watch(Tree(Fallback(move, Sleep(msec=60_000))))
    watched.steps.tick(5)
    (robot,) = watched.run.station.robots.values()
    assert robot.arm.moving
    watched.client.ask("I", hook(2, "FAILURE", mode=1))
    watched.steps.tick(100)
    assert not robot.arm.moving
    assert abs(robot.arm.q[0] - 0.5) > 0.1


def test_hooks_that_cannot_be_are_refused_with_the_others_of_their_list(watch):
    watched = watch(Tree(Sequence(Running(name="wait"), MoveHome())))
    for hooks, error in (
        (hook(2), b"node 2 is of py_trees and cannot have a hook"),
        ([hook(3), {**hook(3), "mode": True}], b"'mode' must be of type int from 0 to 1"),
    ):
        reply = watched.client.send([b"\x02I\0\0\0\0", json.dumps(hooks).encode()])
        assert reply == [b"error", error]
    assert watched.client.hooks() == [] and watched.client.statuses()[1] == IDLE


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_paused_run_goes_on_when_the_publisher_fails(counted, monkeypatch):
    client, steps = counted.client, counted.steps
    client.ask("I", hook(3))
    steps.start_tick()
    client.reached()
    monkeypatch.setattr(publisher_module, "key_of", Mock(side_effect=SystemExit))
    client.requests.send_multipart([b"\x02R\0\0\0\0", b"{}"])
    steps.wait()
    assert counted.count.ticks == 1
