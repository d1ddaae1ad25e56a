"""The dense reward is the progress towards the goal."""

import json

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn.agents import goal_progress
from bt_manip_learn.envs import LearningTask


def test_the_shaping_of_an_episode_telescopes_to_its_first_and_last_progress():
    """Ng, Harada and Russell 1999: shaping adds a constant to the discounted sparse return."""
    task = LearningTask("pick_place", reward="dense", discount=0.9)
    task.reset(0)
    start = goal_progress(task.episodes)
    total, n, success = 0.0, 0, False
    while not success:
        reward, success, _ = task.expert_step()
        total += 0.9**n * reward
        n += 1
    assert 0.0 < start < 0.5
    assert total == pytest.approx(0.9 ** (n - 1) * (1.0 + 0.9) - start, abs=1e-9)


def test_a_lost_object_costs_the_progress_that_was_made():
    from bt_manip.spatial import pose

    task = LearningTask("pick_place", reward="dense", discount=1.0)
    task.reset(0)
    total = sum(task.expert_step().reward for _ in range(20))
    task.episodes.station.cell.move("cube", pose((0.0, 3.0, 0.025)))
    outcome = task.expert_step()
    assert "cube" in outcome.failure and outcome.reward < 0.0
    assert total + outcome.reward == pytest.approx(-start_of(task), abs=1e-9)


def start_of(task):
    """Return the progress at the start of the episode."""
    other = LearningTask("pick_place", reward="dense")
    other.reset(0)
    return goal_progress(other.episodes)


def test_a_state_keeps_the_progress():
    task, other = (LearningTask("pick_place", reward="dense") for _ in range(2))
    task.reset(0)
    for _ in range(30):
        task.expert_step()
    other.set_state(json.loads(json.dumps(task.get_state())))
    assert other.expert_step() == task.expert_step()


def test_a_discount_beyond_one_is_refused():
    with pytest.raises(BtManipError, match="the discount is from 0 to 1, got 1.5"):
        LearningTask("pick_place", reward="dense", discount=1.5)


def test_an_object_that_the_expert_puts_away_is_not_lost():
    task = LearningTask("pick_place_cluttered")
    task.reset(0)
    success = failure = ""
    while not (success or failure):
        _, success, failure = task.expert_step()
    assert success
    assert "cube" not in task.episodes.station.cell.objects
