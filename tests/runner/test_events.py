"""A run as plain events in simulated time."""

import json
import threading

import pytest

from bt_manip.behaviours import MoveHome, RemoveObject, SpawnObject
from bt_manip.bt import (
    Action,
    AlwaysFailure,
    Node,
    Script,
    Sequence,
    Sleep,
    Status,
    SubTree,
    UnsetBlackboard,
)
from bt_manip.exceptions import BtManipError
from bt_manip.record import Recorder
from bt_manip.runner import EventQueue, RunEvent, RunObserver
from bt_manip_recording import log_line
from tests.support.runs import Listener


@pytest.fixture
def events_of(make_run):
    def events(root: Node, **request) -> list[RunEvent]:
        events: list[RunEvent] = []
        make_run(root, **request).execute([Listener(events)])
        return events

    return events


def of_kind(events, kind):
    return [(round(event.time, 6), event.data) for event in events if event.kind == kind]


def test_statuses_and_cycles_have_the_time_of_their_tick_and_the_reason_of_a_failure(events_of):
    root = Sequence("root", Sleep("rest", msec=25), AlwaysFailure("never"))
    events = events_of(root, cycles=2)
    changes = of_kind(events, "status")
    rest = [(t, d["old"], d["status"]) for t, d in changes if d["path"] == "rest"]
    assert rest[:2] == [(0.0, "IDLE", "RUNNING"), (0.03, "RUNNING", "SUCCESS")]
    assert {d["reason"] for _, d in changes if d["status"] != "FAILURE"} == {""}
    assert all(isinstance(d["uid"], int) for _, d in changes)
    cycles = [(d["cycle"], d["status"]) for _, d in of_kind(events, "cycle")]
    assert cycles == [(0, "RUNNING"), (0, "FAILURE"), (1, "RUNNING"), (1, "FAILURE")]
    assert "never" in of_kind(events, "cycle")[1][1]["reason"]


def test_the_tree_comes_first_with_the_parent_and_the_ports_of_each_node(events_of):
    inner = Sequence("inner", SpawnObject("spawn", object="{target}"), Sleep("rest", msec=5))
    root = Sequence("root", SubTree("sub", inner, remap={"target": "{cube}"}, skip_if="false"))
    first = events_of(root)[0]
    assert first.kind == "tree"
    assert [(n["uid"], n["name"], n["parent"]) for n in first.data["nodes"]] == [
        (1, "root", 0), (2, "sub", 1), (3, "inner", 2), (4, "spawn", 3), (5, "rest", 3)
    ]  # fmt: skip
    nodes = {node["name"]: node for node in first.data["nodes"]}
    ports = {port["name"]: port for port in nodes["spawn"]["ports"]}
    assert ports["object"] == {
        "name": "object", "direction": "output", "text": "{target}", "key": "cube"
    }  # fmt: skip
    assert nodes["rest"]["ports"] == [
        {"name": "msec", "direction": "input", "text": "5", "key": ""}
    ]
    assert [(p["name"], p["direction"], p["key"]) for p in nodes["sub"]["ports"]] == [
        ("_skipIf", "script", ""), ("target", "remap", "cube")
    ]  # fmt: skip


def test_an_event_of_another_observer_is_in_the_stream(make_run):
    events, run, other = [], make_run(Sleep("rest", msec=5)), RunObserver()
    other.before_tick = lambda: run.events.emit("edit", {"problems": ["a.xml:3:1: error: no"]})
    run.execute([Listener(events), other])
    edit, *_ = [event for event in events if event.kind == "edit"]
    assert log_line(edit) == ("ERROR", "a.xml:3:1: error: no")


def test_blackboard_changes_are_reported_once_in_the_tick_that_made_them(events_of):
    root = Sequence(
        "root", Script(code="x := 1.5; y := 'a'"), Sleep(msec=15), Script(code="x = 2.5"),
        UnsetBlackboard(key="y"), Sleep(msec=5),
    )  # fmt: skip
    changes = [(t, d["key"], d["value"]) for t, d in of_kind(events_of(root), "blackboard")]
    assert changes == [(0.0, "x", 1.5), (0.0, "y", "a"), (0.02, "x", 2.5), (0.02, "y", None)]


def test_objects_contacts_and_motions_come_and_go(events_of):
    root = Sequence(
        "root",
        SpawnObject(object="{cube}"),
        Sleep(msec=50),
        MoveHome(),
        RemoveObject(object="{cube}"),
    )
    events = events_of(root)
    for event in events:  # they are plain data
        assert json.loads(json.dumps(event.data, allow_nan=False)) == event.data
    cube = [d["present"] for _, d in of_kind(events, "entity") if d["name"] == "cube"]
    assert cube == [True, False]
    contacts = [d["touching"] for _, d in of_kind(events, "contact") if d["first"] == "cube"]
    assert contacts == [True, False]
    assert {d["name"] for t, d in of_kind(events, "entity") if t == 0.0} >= {"table", "panda"}
    assert [d["controller"] for _, d in of_kind(events, "controller")] == ["computed_torque"]


def test_a_motion_has_its_start_and_duration(make_run):
    run = make_run(Sleep("rest", msec=2000))
    run.station.arm.move_to_configuration(run.station.robot.q + 0.2)
    duration = run.station.arm.trajectory.duration
    events: list[RunEvent] = []
    run.execute([Listener(events)])
    (start, first), (end, last) = of_kind(events, "motion")
    assert (first["moving"], last["moving"]) == (True, False)
    assert (start, first["duration"]) == (0.0, duration)
    assert duration <= end <= duration + 0.010


def test_only_the_wanted_kinds_are_reported(make_run):
    events: list[RunEvent] = []
    make_run(Sleep("rest", msec=5)).execute([Listener(events, ("cycle", "entity"))])
    assert {event.kind for event in events} == {"cycle", "entity"}
    with pytest.raises(BtManipError, match="no events are of the kind 'statuses'"):
        make_run(Sleep("rest", msec=5)).execute([Listener([], ("statuses",))])


class Counting(Action):
    """Say how often it has been ticked; succeed at the third tick."""

    def initialise(self):
        self.ticks = 0

    def update(self):
        self.ticks += 1
        self.feedback_message = f"{self.ticks} of 3"
        return Status.SUCCESS if self.ticks == 3 else Status.RUNNING


def test_the_message_of_a_node_is_reported_while_it_runs_and_when_it_succeeds(events_of):
    events = events_of(Sequence("root", Counting("count"), Sleep(msec=15)))
    messages = [(t, d["text"]) for t, d in of_kind(events, "message") if d["path"] == "count"]
    assert messages == [(0.01, "1 of 3"), (0.02, "2 of 3"), (0.02, "3 of 3")]


def test_what_observed_the_tree_before_the_run_still_does_after_it(make_run):
    run = make_run(Sleep("rest", msec=5))
    changes = []
    run.tree.observers.append(note := lambda *change: changes.append(change))
    run.execute([Listener([]), Recorder("test", 0)])
    assert run.tree.observers == [note] and changes
    assert run.interventions.observers == []


def test_a_full_queue_drops_the_oldest_and_counts_them():
    queue = EventQueue(size=3)
    for number in range(5):
        queue.handle(RunEvent(0.0, "tick", {"tick": number}))
    assert [event.data["tick"] for event in queue.take()] == [2, 3, 4]
    assert (queue.dropped, queue.take()) == (2, [])


def test_a_queue_hands_all_events_to_another_thread(make_run):
    queue, taken, direct, done = EventQueue(), [], [], threading.Event()

    def read():
        while not done.is_set():
            taken.extend(queue.take())
        taken.extend(queue.take())

    thread = threading.Thread(target=read)
    thread.start()
    make_run(Sleep("rest", msec=100)).execute([queue, Listener(direct)])
    done.set()
    thread.join()
    assert queue.dropped == 0 and taken == direct
