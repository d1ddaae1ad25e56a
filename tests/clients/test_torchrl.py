"""TorchRL makes the environments, steps them side by side, and collects frames of them."""

import functools

import gymnasium
import pytest

pytest.importorskip("torchrl", reason="TorchRL is not installed")

import torch  # noqa: E402
from torchrl.collectors import Collector  # noqa: E402
from torchrl.envs import GymEnv, GymWrapper, ParallelEnv  # noqa: E402
from torchrl.envs.utils import check_env_specs  # noqa: E402

ID = "bt_manip_learn.envs:bt_manip/PickPlace-v0"  # imported by Gymnasium, also in other processes

make = functools.partial(GymEnv, ID, max_episode_steps=40, reward="dense")


@pytest.mark.parametrize(
    "wrapped", [make, lambda: GymWrapper(gymnasium.make(ID, disable_env_checker=True))]
)
def test_its_checker_accepts_the_environment(wrapped):
    env = wrapped()
    check_env_specs(env)
    assert env.action_spec.shape == (8,)
    env.close()


def test_environments_in_processes_step_like_one():
    env, one = ParallelEnv(2, make), make()
    env.set_seed(0)
    one.set_seed(0)
    found, expected = env.reset(), one.reset()
    actions = env.rand_action()["action"]
    after = env.step(found.set("action", actions))["next"]
    other = one.step(expected.set("action", actions[0]))["next"]
    assert set(after.keys()) >= {"cube_position", "reward", "terminated", "truncated"}
    assert torch.isfinite(after["reward"]).all()
    assert after["cube_position"].shape == (2, *other["cube_position"].shape)
    env.close()
    one.close()


def test_a_collector_has_all_frames():
    collector = Collector(make, None, frames_per_batch=150, total_frames=300)
    frames = [data for data in collector]
    assert sum(data.numel() for data in frames) == 300
    truncated = torch.cat([data["next", "truncated"].flatten() for data in frames])
    episodes = torch.cat([data["collector", "traj_ids"].flatten() for data in frames])
    lengths = torch.bincount(episodes)
    assert truncated.any() and (lengths[episodes[truncated]] == 40).all()
    assert lengths.max() == 40  # a random action may end one earlier
    collector.shutdown()
