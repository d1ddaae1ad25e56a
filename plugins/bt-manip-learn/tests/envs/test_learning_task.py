"""The task of a tree judges each episode by its own start."""

import json
from dataclasses import replace

import numpy as np
from dm_control.composer.variation import distributions

from bt_manip.cell.randomization import Randomization
from bt_manip.scenes import table_and_basket
from bt_manip.spatial import pose
from bt_manip_learn.envs import LearningTask


def test_a_state_keeps_how_low_objects_may_lie(parts):
    """The basket is the lowest thing that the goal names, at another height in each episode."""
    where = {"position": distributions.Uniform((0.0, 2.0, 0.4), (0.0, 2.0, 0.9))}
    fixtures = tuple(replace(one, within_reach=False) for one in table_and_basket().objects)
    varied = Randomization(objects={"basket": where})
    scene = replace(table_and_basket(), objects=fixtures, randomization=varied)
    scenes = parts.scenes.with_part("heights", lambda: scene)
    task = LearningTask("pick_place", parts=replace(parts, scenes=scenes), scene="heights")
    cell, heights = task.episodes.station.cell, []
    for episode in (0, 1):
        task.reset(0, episode)
        heights.append(cell.pose("basket").translation[2])
    low, high = (heights.index(one) for one in (min(heights), max(heights)))
    task.reset(0, low)
    cell.move("cube", pose((0.3, 0.0, sum(heights) / 2 - 0.1)), overlap=1.0)
    assert not task.judge().failure
    state = json.loads(json.dumps(task.get_state()))
    task.reset(0, high)
    task.set_state(state)
    assert not task.judge().failure


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
