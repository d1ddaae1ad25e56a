"""RLlib trains in the environment, flattened to one array."""

import gymnasium
import pytest

pytest.importorskip("ray.rllib", reason="RLlib is not installed")

import ray  # noqa: E402
from ray.rllib.algorithms.ppo import PPOConfig  # noqa: E402
from ray.tune.registry import register_env  # noqa: E402


def make(options):
    """Return the environment."""
    import bt_manip_learn.envs  # noqa: F401 (registers the ids)

    return gymnasium.wrappers.FlattenObservation(gymnasium.make("bt_manip/PickPlace-v0", **options))


def test_it_trains_an_iteration():
    ray.init(num_cpus=2, include_dashboard=False)
    register_env("pick_place", make)
    try:
        options = {"reward": "dense", "max_episode_steps": 25}
        config = (
            PPOConfig()
            .environment("pick_place", env_config=options)
            .env_runners(num_env_runners=0)
            .training(train_batch_size=100, minibatch_size=50, num_epochs=1)
        )
        algorithm = config.build_algo()
        found = algorithm.train()
        assert found["env_runners"]["num_episodes"] >= 3
        assert -1.0 <= found["env_runners"]["episode_return_mean"] <= 2.0
        algorithm.stop()
    finally:
        ray.shutdown()
