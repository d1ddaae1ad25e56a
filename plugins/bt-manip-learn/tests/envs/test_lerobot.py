"""LeRobot's own evaluation runs in an environment of a tree."""

import enum
import importlib
import json
import subprocess
import sys
from collections import namedtuple
from dataclasses import dataclass, field
from types import ModuleType

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box

TINY = "dim_model=32 n_heads=2 dim_feedforward=64 n_encoder_layers=1 n_vae_encoder_layers=1"


def run(python, *words):
    done = subprocess.run([python, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.splitlines()


def test_lerobot_evaluates_an_untrained_policy(lerobot, opengl, tmp_path):
    tiny = [f"--policy.{one}" for one in TINY.split()]
    run(
        lerobot, "-m", "lerobot.scripts.lerobot_eval",
        "--env.discover_packages_path=bt_manip_learn.lerobot", "--env.type=bt_manip",
        "--env.task=pick_place", "--env.episode_length=3",
        "--env.options={action: cartesian_deltas}", f"--output_dir={tmp_path}",
        "--eval.n_episodes=1", "--eval.batch_size=1", "--policy.type=act", "--policy.device=cpu",
        "--policy.push_to_hub=false", *tiny,
    )  # fmt: skip
    found = json.loads((tmp_path / "eval_info.json").read_text())["overall"]
    assert (found["n_episodes"], found["pc_success"]) == (1, 0.0)
    assert (tmp_path / "videos" / "bt_manip_0" / "eval_episode_0.mp4").stat().st_size > 1000


Feature = namedtuple("Feature", "type shape")  # stands for LeRobot's PolicyFeature


@dataclass
class Config:
    """Stands for LeRobot's ``EnvConfig``."""

    features: dict = field(default_factory=dict)
    features_map: dict = field(default_factory=dict)

    @staticmethod
    def register_subclass(name):
        return lambda cls: cls


@pytest.fixture
def package(monkeypatch):
    """Import the package beside stand-ins for LeRobot's classes."""
    kinds = enum.Enum("FeatureType", ["ACTION", "STATE", "ENV", "VISUAL"])
    types = {"FeatureType": kinds, "PolicyFeature": Feature}
    modules = {"configs.types": types, "envs.configs": {"EnvConfig": Config}}
    for name, attributes in {"configs": {}, "envs": {}, **modules}.items():
        module = ModuleType(f"lerobot.{name}")
        vars(module).update(attributes)
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(sys.modules, "lerobot", ModuleType("lerobot"))
    package = importlib.import_module("bt_manip_learn.lerobot")
    yield package
    del sys.modules[package.__name__], gymnasium.registry[package.ID]


def test_observations_are_in_groups_actions_are_clipped_and_episodes_are_cut(package, monkeypatch):
    config = package.BtManipEnv(episode_length=2, fps=10)
    env = package.LeRobotEnvironment(**config.gym_kwargs)
    task, space = env.task, env.action_space
    assert task.episodes.step_time == 0.1 and package.BtManipEnv().fps == 20
    observation, _ = env.reset(seed=0)
    specs, values = task.observations.specs.items(), task.observe()
    for key, group in (("agent_pos", "robot"), ("environment_state", "simulator")):
        expected = np.concatenate([values[name] for name, one in specs if one.group == group])
        np.testing.assert_array_equal(observation[key], expected)
        assert env.observation_space[key] == Box(-np.inf, np.inf, expected.shape, np.float32)
        assert config.features[key].shape == expected.shape
    assert config.features["action"] == (package.FeatureType.ACTION, space.shape)
    assert config.features_map == {
        "action": "action",
        "agent_pos": "observation.state",
        "environment_state": "observation.environment_state",
    }
    limits = task.episodes.station.arm.model.limits
    np.testing.assert_allclose(space.low[:7], limits.lower, rtol=1e-6)  # in physical units
    assert env.action_names == task.action.space.names
    assert env.task_description == "put the object into the basket"
    taken = []
    monkeypatch.setattr(task.action, "step", taken.append)
    for _ in range(2):
        assert [env.step(end)[3] for end in (space.low - 9, space.high + 9)] == [False, True]
        np.testing.assert_array_equal(taken[-2:], [space.low, space.high])
        env.reset()
    images = package._space_of({"pixels": {"overview": np.zeros((2, 3, 3), np.uint8)}})
    assert images["pixels"]["overview"] == Box(0, 255, (2, 3, 3), np.uint8)
