"""Episodes of environments are recorded, disturbed and watched like runs of trees."""

import json

import gymnasium
import numpy as np
import pytest

import bt_manip_learn.envs  # noqa: F401 (registers the environments)
from bt_manip.exceptions import BtManipError
from bt_manip.record import Recorder
from bt_manip_learn.envs import LearningTask
from bt_manip_recording import Continuation, Recording
from tests.support.runs import Listener

FAULT = "vanish at=SpawnObject after=0.2"


class Log(Listener):
    """Keeps events, and counts the runs that have ended."""

    ended = 0

    def run_ended(self) -> None:
        self.ended += 1


def hold(task: LearningTask) -> np.ndarray:
    """Return the action that keeps the arm where it is, with an open gripper."""
    return np.append(task.episodes.station.robot.q, -1.0)


def cycles(path) -> list[dict]:
    return [event.data for event in Recording(path).events("cycle")]


@pytest.fixture
def page(parts):
    from bt_manip_view import Page

    panels = parts.of("panels")
    page = Page({name: panels.get(name) for name in panels.in_order()}, port=0, speed=None)
    yield page
    page.close()


def test_each_episode_of_an_environment_is_a_recording_and_watched_on_the_page(tmp_path, page):
    env = gymnasium.make(
        "bt_manip/PickPlace-v0", record=str(tmp_path / "run-{episode}.mcap"), faults=(FAULT,),
        observers=(page,), physical_units=True,
    )  # fmt: skip
    task = env.unwrapped.task
    env.reset(seed=3)
    failed, steps = False, 0
    while not failed:
        *_, failed, _, info = env.step(hold(task))
        steps += 1
    assert info["failure"] == "'cube' has left the cell"
    page.refresh(now=True)
    (shown,) = (one[-1] for one in json.loads(page.gui.snapshot()[1]) if "status" in one)
    assert "cycle 1" in shown["text"] and "FAILURE" in shown["text"]
    env.reset()
    env.step(hold(task))
    env.close()
    first, second = tmp_path / "run-0.mcap", tmp_path / "run-1.mcap"
    ends = [(one["status"], one["reason"]) for one in cycles(first)]
    assert ends == [("RUNNING", ""), ("FAILURE", "'cube' has left the cell")]
    assert [one["status"] for one in cycles(second)] == ["RUNNING"]  # it has no end
    recording = Recording(first)
    identity = recording.identity
    assert (identity["seed"], identity["agent"], identity["tree"]) == (
        3, "joint_targets", "pick_place",
    )  # fmt: skip
    assert identity["modifiers"] == {"fault": [FAULT]}
    assert recording.end == pytest.approx(0.05 * steps, abs=0.02)
    assert len(recording.control_steps()["t"]) == pytest.approx(50 * steps, abs=20)


def test_a_name_without_a_number_records_the_first_episode_until_a_state_is_restored(tmp_path):
    path = tmp_path / "run.mcap"
    task = LearningTask("pick_place", record=str(path))
    task.reset(0, 4)
    task.step(hold(task))
    state = json.loads(json.dumps(task.get_state()))
    task.step(hold(task))
    task.set_state(state)
    task.step(hold(task))
    task.reset(0, 5)
    task.step(hold(task))
    task.close()
    assert Recording(path).end == pytest.approx(0.1, abs=0.02)  # the restored state ended it
    assert [path.name for path in tmp_path.glob("*.mcap")] == ["run.mcap"]
    assert [one["cycle"] for one in cycles(path)] == [4]
    with pytest.raises(BtManipError, match="in which an agent acted"):
        Continuation(Recording(path), 0.02)


def test_observers_see_an_agents_episode_as_a_cycle_and_change_nothing():
    events = []
    log = Log(events)
    task, plain = LearningTask("pick_place", observers=(log,)), LearningTask("pick_place")
    for one in (task, plain):
        one.reset(0, 2)
        for _ in range(3):
            one.step(hold(one) + 0.02)
    states = [one.episodes.station.cell.state_bytes() for one in (task, plain)]
    assert states[0] == states[1]
    task.reset(0, 3)
    kinds = {event.kind for event in events}
    assert {"tree", "status", "cycle", "entity", "blackboard", "contact", "tick"} <= kinds
    assert [one.data["cycle"] for one in events if one.kind == "cycle"] == [2, 3]
    assert log.ended == 1
    task.close()
    assert log.ended == 2


def test_a_state_that_diverges_in_the_grip_ends_the_episode_with_its_reason():
    recorder = Recorder("pick_place", 0)
    task = LearningTask("pick_place", observers=(recorder,))
    task.reset(0)
    gripper = task.episodes.station.gripper
    while not gripper.held:
        task.episodes.expert_step()
    task.step(np.append(task.episodes.station.robot.q, 1.0))
    task.episodes.station.cell.data.qvel[:] = np.nan
    outcome = task.step(hold(task))
    assert not outcome.success and outcome.failure.startswith("MuJoCo warned")
    (cycle,) = recorder.report().cycles
    assert (cycle.status, cycle.reason) == ("FAILURE", outcome.failure)
    assert (cycle.object, cycle.placed, cycle.goal) == ("cube", False, False)
    task.close()
