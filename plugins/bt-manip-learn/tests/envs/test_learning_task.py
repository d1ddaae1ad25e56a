"""The task of a tree judges each episode by its own start."""

import json

import numpy as np

from bt_manip_learn.envs import LearningTask


def test_a_state_keeps_how_low_objects_may_lie(parts):
    """The basket is the lowest thing that the goal names, at another height in each episode."""
    task = LearningTask("pick_place", parts=parts)
    task.reset(0)
    assert not task.judge().failure
    state = json.loads(json.dumps(task.get_state()))
    state["losses"]["lowest"] += 2.0
    task.set_state(state)
    assert task.judge().failure == "'cube' has fallen"
    assert task.get_state()["losses"] == state["losses"]
    task.reset(1)
    assert not task.judge().failure  # by the heights of its own start


def test_a_level_is_drawn_in_each_episode(parts):
    task = LearningTask("pick_place", parts=parts, vary={"scene.mass": 2})
    masses = []
    for episode in (0, 1):
        task.reset(0, episode)
        masses.append(task.episodes.station.randomizer.sampled["objects"]["cube"]["mass"])
    assert masses[0] != masses[1]


def test_diverged_physics_end_an_episode_and_a_state_keeps_the_verdict_on_objects_that_left(parts):
    task = LearningTask("pick_place", parts=parts, reward="dense")
    task.reset(0)
    before = task.progress
    assert task.judge("it diverged") == (-before, False, "it diverged")
    task.reset(0)
    task.episodes.station.cell.remove("cube")
    action = np.zeros(task.action.space.shape)
    assert task.step(action).failure == "'cube' has left the cell"
    state = json.loads(json.dumps(task.get_state()))
    task.reset(1)
    task.set_state(state)
    assert task.episodes.ended
    assert json.loads(json.dumps(task.get_state())) == state
