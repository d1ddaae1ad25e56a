"""Stable-Baselines3 learns in the environments, with the wrappers that its users have."""

import importlib.util
import re
from pathlib import Path

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed")

from gymnasium.wrappers import RecordEpisodeStatistics  # noqa: E402
from stable_baselines3 import PPO, SAC, HerReplayBuffer  # noqa: E402
from stable_baselines3.common.callbacks import BaseCallback, EvalCallback  # noqa: E402
from stable_baselines3.common.env_checker import check_env  # noqa: E402
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor  # noqa: E402

from bt_manip_learn.envs.stable_baselines import BatchVecEnv  # noqa: E402

ID = "bt_manip/PickPlace-v0"

STEPS = 600
SMALL = {"net_arch": [32, 32]}


def make(task, **options):
    made = gymnasium.make(f"bt_manip/{task}-v0", max_episode_steps=100, **options)
    return RecordEpisodeStatistics(made)


def vector(task, **options):
    return VecMonitor(DummyVecEnv([lambda: make(task, **options)]))


class Ended(BaseCallback):
    """Counts the ends of episodes, and keeps the keys of their infos."""

    def __init__(self):
        super().__init__()
        self.lengths, self.keys = [], set()

    def _on_step(self):
        for done, info in zip(self.locals["dones"], self.locals["infos"], strict=True):
            if done:
                self.lengths.append(info["episode"]["l"])
                self.keys |= set(info)
        return True


@pytest.mark.parametrize("task", ["PickPlace", "PressButton", "OpenDrawer"])
def test_its_checker_accepts_the_environment(task):
    check_env(gymnasium.make(f"bt_manip/{task}-v0").unwrapped)


@pytest.mark.parametrize(("algorithm", "task"), [(PPO, "OpenDrawer"), (SAC, "PickPlace")])
def test_it_learns(task, algorithm, tmp_path):
    options = {"learning_starts": 200, "train_freq": 8} if algorithm is SAC else {"n_steps": 150}
    env = vector(task, reward="dense")
    model = algorithm(
        "MultiInputPolicy", env, policy_kwargs=dict(SMALL), seed=0, device="cpu", **options
    )
    ended = Ended()
    evaluation = EvalCallback(
        vector(task), n_eval_episodes=2, eval_freq=STEPS // 2, log_path=str(tmp_path), verbose=0
    )
    before = [one.detach().clone() for one in model.policy.parameters()]
    model.learn(STEPS, callback=[ended, evaluation], log_interval=1)
    after = list(model.policy.parameters())
    assert any(not np.array_equal(a, b.detach()) for a, b in zip(before, after, strict=True))
    assert len(ended.lengths) >= STEPS // 100 and max(ended.lengths) <= 100
    assert {"is_success", "episode_number"} <= ended.keys
    found = np.load(tmp_path / "evaluations.npz")
    assert found["timesteps"].tolist() == [STEPS // 2, STEPS] and found["successes"].shape == (2, 2)
    env.close()
    evaluation.eval_env.close()


def test_it_relabels_goals():
    env = vector("PickPlace", goal_conditioned=True, action="cartesian_deltas")
    model = SAC(
        "MultiInputPolicy", env, replay_buffer_class=HerReplayBuffer, learning_starts=200,
        train_freq=8, policy_kwargs=dict(SMALL), seed=0, device="cpu",
    )  # fmt: skip
    model.learn(2 * STEPS)
    batch = model.replay_buffer.sample(500)
    goals = batch.observations["desired_goal"].numpy()
    assert len(np.unique(goals.round(4), axis=0)) > 10  # the basket, and where the cube was
    rewards = batch.rewards.numpy()
    assert set(np.unique(rewards)) == {-1.0, 0.0}  # relabelled goals are reached
    env.close()


def test_it_learns_in_a_batch_with_the_results_of_single_environments():
    options = {"reward": "dense", "controller": "native_pd", "max_episode_steps": 30}
    batch = VecMonitor(BatchVecEnv("pick_place", 4, **options))
    singles = VecMonitor(DummyVecEnv([lambda: gymnasium.make(ID, **options)] * 4))
    trained = []
    for env in (batch, singles):
        model = PPO(
            "MultiInputPolicy", env, n_steps=64, policy_kwargs=dict(SMALL), seed=0, device="cpu"
        )
        ended = Ended()
        model.learn(256, callback=ended)
        weights = [one.detach().numpy() for one in model.policy.parameters()]
        trained.append((ended.lengths, ended.keys, weights))
        env.close()
    (lengths, keys, weights), (others, other_keys, other_weights) = trained
    assert lengths == others and len(lengths) >= 8
    assert keys == other_keys
    assert all(np.array_equal(a, b) for a, b in zip(weights, other_weights, strict=True))


def test_the_example_trains_and_evaluates(capsys):
    path = Path(__file__).parents[2] / "examples" / "6_learn_to_reach.py"
    spec = importlib.util.spec_from_file_location("learn_to_reach", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.ENVIRONMENTS, example.EPISODE, example.ROUND = 4, 10, 1
    example.learn(1e-3)
    lines = capsys.readouterr().out.splitlines()
    steps = [
        re.fullmatch(r"0\.\d min, (\d+) steps: \d+%, return -?\d\.\d\d", line)[1] for line in lines
    ]
    assert steps == ["0", "128"]
