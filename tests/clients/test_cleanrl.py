"""CleanRL's PPO learns, in the file of its wheel."""

import functools
import runpy
import sys

import gymnasium
import pytest
from gymnasium.wrappers import TransformObservation
from gymnasium.wrappers.vector import ClipAction, FlattenObservation, RecordEpisodeStatistics

pytest.importorskip("cleanrl", reason="CleanRL is not installed")

ID = "bt_manip_learn.envs:bt_manip/PickPlace-v0"
STEPS, ENVIRONMENTS = 32, 2


class Transformed(TransformObservation):
    """Takes a function alone, as in the Gymnasium of the wheel."""

    def __init__(self, env, function):
        super().__init__(env, function, env.observation_space)


def batch(functions):
    """Return a batch with the wrappers of single environments, in place of their functions."""
    made = gymnasium.make_vec(ID, len(functions), vectorization_mode="vector_entry_point")
    return ClipAction(RecordEpisodeStatistics(FlattenObservation(made)))


@pytest.mark.parametrize("vector", ["async", "batch"])
def test_ppo_learns(vector, monkeypatch, tmp_path, capsys):
    forked = functools.partial(gymnasium.vector.AsyncVectorEnv, context="fork")
    monkeypatch.setattr(gymnasium.vector, "SyncVectorEnv", forked if vector == "async" else batch)
    monkeypatch.setattr(gymnasium.wrappers, "TransformObservation", Transformed)
    monkeypatch.chdir(tmp_path)
    words = {
        "--env-id": ID, "--total-timesteps": 2 * STEPS * ENVIRONMENTS, "--num-steps": STEPS,
        "--num-envs": ENVIRONMENTS, "--num-minibatches": 4, "--update-epochs": 2, "--cuda": False,
        "--exp-name": "ppo",
    }  # fmt: skip
    given = [str(text) for pair in words.items() for text in pair]
    monkeypatch.setattr(sys, "argv", ["ppo", *given])
    runpy.run_module("cleanrl.ppo_continuous_action", run_name="__main__")
    assert capsys.readouterr().out.count("SPS:") == 2  # updates
