"""Minari reads the exported demonstrations, and makes their environment again."""

import subprocess
import sys

import numpy as np
import pytest

minari = pytest.importorskip("minari", reason="Minari is not installed")

from bt_manip_learn.demonstrations import read_demonstrations  # noqa: E402


def test_its_reader_has_the_demonstrations_and_their_environment(tmp_path, monkeypatch):
    command = [sys.executable, "-m", "bt_manip", "demos"]
    export = ["export", "demos", "--format", "minari", "-o", "pick_place-v0"]
    for words in (["pick_place", "--episodes", "3", "--to", "demos"], export):
        subprocess.run([*command, *words], cwd=tmp_path, check=True, capture_output=True)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    dataset, store = minari.load_dataset("pick_place-v0"), read_demonstrations(tmp_path / "demos")
    assert dataset.total_episodes == 3
    for read, one in zip(dataset.iterate_episodes(), store, strict=True):
        assert len(read) == len(one) and read.terminations[-1] and not read.terminations[:-1].any()
        assert np.array_equal(read.observations["cube_position"], one.observations["cube_position"])
        assert np.array_equal(read.rewards, one.rewards)
    env = dataset.recover_environment()
    assert env.action_space == dataset.action_space
    observation, _ = env.reset(seed=0, options={"episode": 0})
    first = dataset[0]
    assert np.array_equal(observation["cube_position"], first.observations["cube_position"][0])
    assert env.observation_space.keys() == first.observations.keys()
    for action in first.actions:
        *_, terminated, _, info = env.step(action)
        if terminated:
            break
    assert info["is_success"]
    env.close()
