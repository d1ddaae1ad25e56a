"""The dense reward is the progress made towards the goal; the shaped one preserves the optimum."""

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import RecordEpisodeStatistics

import bt_manip_learn.envs  # noqa: F401 (registers the ids)
from bt_manip.exceptions import BtManipError
from bt_manip.spatial import pose
from bt_manip_learn.agents import goal_progress
from bt_manip_learn.envs import LearningTask
from bt_manip_learn.envs.gymnasium_env import GymnasiumEnvironment


@pytest.mark.parametrize(("options", "discount"), [({}, 1.0), ({"discount": 0.9}, 0.9)])
def test_the_progress_of_an_episode_telescopes_to_that_of_its_start_and_end(options, discount):
    """Ng, Harada and Russell 1999: shaping adds a constant to the discounted sparse return."""
    task = LearningTask("pick_place", reward="shaped" if options else "dense", **options)
    assert task.reward_bounds == (-1.0, 1.0 + discount)  # all progress lost; all made at once
    task.reset(0)
    start = goal_progress(task.episodes)
    total, n, success = 0.0, 0, False
    while not success:
        reward, success, _ = task.expert_step()
        total += discount**n * reward
        n += 1
    assert 0.0 < start < 0.5
    assert total == pytest.approx(discount ** (n - 1) * (1.0 + discount) - start, abs=1e-9)
    assert task.progress == 1.0


def test_a_lost_object_costs_the_progress_that_was_made():
    task = LearningTask("pick_place", reward="shaped")  # by default with the discount 0.99
    assert task.reward_bounds == (-1.0, 1.99)
    task.reset(0)
    for _ in range(20):
        before = goal_progress(task.episodes)
        expected = task.expert_step().reward + before
        assert 0.99 * goal_progress(task.episodes) == pytest.approx(expected, abs=1e-9)
    before = task.progress
    task.episodes.station.cell.move("cube", pose((0.0, 3.0, 0.025)))
    outcome = task.expert_step()
    assert "cube" in outcome.failure and before > 0.2
    assert outcome.reward == pytest.approx(-before, abs=1e-9) and task.progress == 0.0


TREE = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Look" _goal="ObjectExists object={cube}">
    <Sequence><SpawnObject object="{cube}"/><MoveHome/></Sequence>
  </BehaviorTree>
</root>
"""


def test_a_condition_without_progress_or_position_is_refused_by_its_name(tmp_path):
    path = tmp_path / "look.xml"
    path.write_text(TREE)
    for reward in ("dense", "shaped"):
        with pytest.raises(BtManipError, match="ObjectExists has no method 'places' or 'progress'"):
            LearningTask(str(path), reward=reward)
    with pytest.raises(BtManipError, match="not a position: 'ObjectExists'"):
        GymnasiumEnvironment(str(path), goal_conditioned=True)


def test_the_dense_return_of_an_agent_is_the_progress_made():
    env = gymnasium.make("bt_manip/PickPlace-v0", reward="dense", max_episode_steps=10)
    env = RecordEpisodeStatistics(env)
    _, info = env.reset(seed=0)
    rng, seen, truncated = np.random.default_rng(0), [info["progress"]], False
    while not truncated:
        *_, truncated, info = env.step(rng.uniform(-1.0, 1.0, env.action_space.shape))
        seen.append(info["progress"])
    assert all(0.0 <= value <= 1.0 for value in seen)
    assert info["episode"]["r"] == pytest.approx(seen[-1] - seen[0])
