"""LeRobot itself writes the dataset, in an environment of its own."""

import subprocess
import sys

import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn.demonstrations import DemonstrationStore, write_lerobot
from bt_manip_learn.demonstrations.lerobot_script import feature

from .conftest import IDENTITY, STEPS

READ = """
import sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
dataset = LeRobotDataset("bt_manip/dataset", root=sys.argv[1])
step = dataset[6]
print(dataset.num_episodes, len(dataset), dataset.fps, step["task"], step["leaf"])
print(*(step[f"observation.{one}state"].shape[0] for one in sys.argv[2:]))
print(tuple(step["observation.images.overview"].shape), step["action"][0].item())
print(*dataset.meta.features["action"]["names"])
"""

TRAIN = """
import sys
import torch
from lerobot.configs.types import FeatureType
from lerobot.datasets.lerobot_dataset import LeRobotDataset, LeRobotDatasetMetadata
from lerobot.datasets.utils import dataset_to_policy_features
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors

about = LeRobotDatasetMetadata("bt_manip/dataset", root=sys.argv[1])
features = dataset_to_policy_features(about.features)
config = ACTConfig(
    input_features={k: one for k, one in features.items() if k.startswith("observation.")},
    output_features={k: one for k, one in features.items() if one.type is FeatureType.ACTION},
    chunk_size=4, n_action_steps=4, dim_model=32, n_heads=2, dim_feedforward=64, device="cpu",
    n_encoder_layers=1, n_vae_encoder_layers=1, pretrained_backbone_weights=None,
)
times = {"action": [i / about.fps for i in range(4)]}
dataset = LeRobotDataset("bt_manip/dataset", root=sys.argv[1], delta_timestamps=times)
torch.manual_seed(0)
policy = ACTPolicy(config)
prepare, _ = make_pre_post_processors(config, dataset_stats=about.stats)
batch = prepare(next(iter(torch.utils.data.DataLoader(dataset, batch_size=4))))
optimizer = torch.optim.AdamW(policy.parameters(), 1e-3)
losses = []
for _ in range(5):
    loss, _ = policy.forward(batch)
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()
    losses.append(loss.item())
print(*config.input_features)
print(*losses)
"""


def lines_of(python, script, *words):
    """Return the lines that a script prints."""
    command = [python, "-c", script, *words]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


@pytest.mark.parametrize(("observations", "sizes"), [("robot", "2"), ("all", "2 3")])
def test_lerobot_reads_the_dataset(lerobot, store, tmp_path, observations, sizes):
    folder = tmp_path / "dataset"
    assert write_lerobot(store, folder, "joint_targets", lerobot, observations) == 3
    states = ["", "environment_"][: len(sizes.split())]
    lines = lines_of(lerobot, READ, str(folder), *states)
    assert lines[0] == f"3 {3 * STEPS} 20 pick the red cube up {store.read(1).leaves[1]}"
    assert lines[1] == sizes
    shape, action = lines[2].rsplit(" ", 1)
    assert shape == "(3, 8, 12)"
    assert float(action) == pytest.approx(store.read(1).actions["joint_targets"][1, 0])
    assert lines[3] == "a b c"


@pytest.mark.parametrize(("kinds", "observed"), [(["rgb"], "robot"), ([], "all")])
def test_act_learns_from_the_default_export(lerobot, tmp_path, make_demonstration, kinds, observed):
    identity = {**IDENTITY, "images": {"kinds": kinds}}
    store = DemonstrationStore.create(tmp_path / "demos", identity)
    demo = make_demonstration()
    if not kinds:
        del demo.observations["overview_rgb"]
    store.write(demo)
    folder = tmp_path / "dataset"
    write_lerobot(store, folder, "joint_targets", lerobot)
    names, losses = lines_of(lerobot, TRAIN, str(folder))
    beside = {"robot": "observation.images.overview", "all": "observation.environment_state"}
    assert set(names.split()) == {"observation.state", beside[observed]}
    first, *_, last = map(float, losses.split())
    assert last < first


def test_features_are_texts_images_and_vectors():
    image = {"dtype": "image", "shape": (2, 4, 3), "names": ["height", "width", "channels"]}
    assert feature("pick/Reach") == {"dtype": "string", "shape": (1,), "names": None}
    assert feature(np.zeros((2, 4, 3), np.uint8)) == image
    assert feature(np.zeros(7, np.float32)) == {"dtype": "float32", "shape": (7,), "names": None}


def test_a_python_without_lerobot_is_named(store, tmp_path):
    python = tmp_path / "python"
    python.write_text(f"#!/bin/sh\nexec {sys.executable} -S -c 'import lerobot'\n")
    python.chmod(0o755)
    with pytest.raises(BtManipError, match=r"lerobot in '.*python' failed: ModuleNotFoundError"):
        write_lerobot(store, tmp_path / "dataset", "joint_targets", str(python))
    with pytest.raises(BtManipError, match="'/nowhere/python' does not run: No such file"):
        write_lerobot(store, tmp_path / "dataset", "joint_targets", "/nowhere/python")
    with pytest.raises(BtManipError, match="exists: choose another folder"):
        write_lerobot(store, tmp_path, "joint_targets", sys.executable)
