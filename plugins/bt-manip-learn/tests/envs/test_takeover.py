"""The expert takes over at any step, and says what it would do."""

import json

import gymnasium
import numpy as np
import pytest

import bt_manip_learn.envs  # noqa: F401 (registers the ids)
from bt_manip.exceptions import BtManipError
from bt_manip_learn.envs import LearningTask


def act_at_random(task, seed, steps):
    """Start an episode with random actions; return whether they leave the task possible."""
    task.reset(seed)
    rng, space = np.random.default_rng(seed), task.action.space
    return not any(task.step(rng.uniform(space.low, space.high)).failure for _ in range(steps))


def finish(task):
    """Let the expert act until the end; return whether it succeeds."""
    for _ in range(400):
        outcome = task.expert_step()
        if outcome.success or outcome.failure:
            break
    return outcome.success


@pytest.fixture(scope="module")
def task(parts):
    return LearningTask("pick_place", parts=parts)


def test_the_expert_takes_over_from_an_agent_and_an_agent_from_the_expert(task):
    assert act_at_random(task, 1, 10)
    cubes = [name for name in task.episodes.station.cell.objects if name.startswith("cube")]
    for _ in range(20):
        task.expert_step()
    task.step(task.expert_action())
    assert finish(task)
    assert cubes == ["cube"]  # no second one is added


def test_the_expert_takes_over_where_it_has_put_objects_away(parts):
    task = LearningTask("pick_place_cluttered", parts=parts)
    task.reset(1)
    cell = task.episodes.station.cell
    while "cube" in cell.objects:
        task.expert_step()
    assert any(name.startswith("cube") for name in cell.objects)  # the expert goes on with it
    task.step(task.expert_action())
    assert finish(task)


@pytest.mark.soak
@pytest.mark.parametrize("steps", [1, 10, 100])
def test_the_expert_succeeds_after_random_actions(task, steps):
    successes = 0
    for seed in range(50):
        successes += act_at_random(task, seed, steps) and finish(task)
    assert successes >= 45


def test_the_action_of_the_expert_is_that_of_its_next_step_and_changes_nothing(task):
    for before in (task.expert_step, lambda: task.step(task.action.recorded())):
        task.reset(3)
        for _ in range(15):
            before()
        state = json.dumps(task.get_state())
        action = task.expert_action()
        assert json.dumps(task.get_state()) == state
        task.action.watch()
        task.expert_step()
        assert np.array_equal(task.action.recorded(), action)
        assert np.isfinite(action).all() and action.any()


def test_an_expert_that_cannot_go_on_says_why(task):
    assert act_at_random(task, 0, 2)
    task.episodes.station.cell.remove("cube")
    with pytest.raises(BtManipError, match="cannot go on from the actions of the agent: .*'cube'"):
        for _ in range(200):
            task.episodes.expert_step()


def test_a_gymnasium_environment_steps_with_the_expert_in_the_units_of_its_actions():
    env = gymnasium.make("bt_manip/PickPlace-v0", disable_env_checker=True)
    env.reset(seed=0)
    env.step(env.action_space.sample())
    label = env.unwrapped.expert_action()
    *_, info = env.unwrapped.expert_step()
    assert env.action_space.contains(label)
    assert np.array_equal(info["expert_action"], label)
