"""LeRobot itself writes the dataset, in an environment of its own."""

import os
import subprocess
import sys

import pytest

from bt_manip.demonstrations import DemonstrationStore, write_lerobot
from bt_manip.exceptions import BtManipError
from tests.demonstrations.conftest import IDENTITY, STEPS

READ = """
import sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
dataset = LeRobotDataset("bt_manip/dataset", root=sys.argv[1])
step = dataset[6]
print(dataset.num_episodes, len(dataset), dataset.fps, step["task"], step["leaf"])
print(*(step[f"observation.{one}state"].shape[0] for one in sys.argv[2:]))
print(tuple(step["observation.images.overview"].shape), step["action"][0].item())
"""


@pytest.mark.parametrize(("observations", "sizes"), [("robot", "2"), ("all", "2 3")])
def test_lerobot_reads_the_dataset(store, tmp_path, observations, sizes):
    python = os.environ.get("LEROBOT_PYTHON")
    if python is None:
        pytest.skip("LEROBOT_PYTHON is not set: the Python of an environment with lerobot")
    folder = tmp_path / "dataset"
    assert write_lerobot(store, folder, "joint_targets", python, observations) == 3
    script = tmp_path / "read.py"
    script.write_text(READ)
    states = ["", "environment_"][: len(sizes.split())]
    command = [python, str(script), str(folder), *states]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    assert lines[0] == f"3 {3 * STEPS} 20 pick the cube up {store.read(1).leaves[1]}"
    assert lines[1] == sizes
    shape, action = lines[2].rsplit(" ", 1)
    assert shape == "(3, 8, 12)"
    assert float(action) == pytest.approx(store.read(1).actions["joint_targets"][1, 0])


def test_a_python_without_lerobot_is_named(store, tmp_path):
    python = tmp_path / "python"
    python.write_text(f"#!/bin/sh\nexec {sys.executable} -S -c 'import lerobot'\n")
    python.chmod(0o755)
    with pytest.raises(BtManipError, match=r"lerobot in '.*python' failed: ModuleNotFoundError"):
        write_lerobot(store, tmp_path / "dataset", "joint_targets", str(python))
    with pytest.raises(BtManipError, match="'/nowhere/python' does not run: No such file"):
        write_lerobot(store, tmp_path / "dataset", "joint_targets", "/nowhere/python")


def test_an_existing_folder_is_refused(store, tmp_path):
    with pytest.raises(BtManipError, match="exists: choose another folder"):
        write_lerobot(store, tmp_path, "joint_targets", sys.executable)


def test_an_empty_folder_is_refused(tmp_path):
    empty = DemonstrationStore.create(tmp_path / "empty", IDENTITY)
    with pytest.raises(BtManipError, match="has no demonstrations to export"):
        write_lerobot(empty, tmp_path / "dataset", "joint_targets", sys.executable)
