"""The Parquet table has a row for each environment step."""

import json
import struct

import numpy as np
from pyarrow import parquet

from bt_manip_learn.demonstrations import write_demonstration_table

from .conftest import IDENTITY, STEPS


def test_rows_are_the_steps_of_all_demonstrations(store, tmp_path):
    path = tmp_path / "demos.parquet"
    assert write_demonstration_table(store, path) == 3
    table = parquet.read_table(path).to_pydict()
    assert table["episode"] == [0] * STEPS + [1] * STEPS + [3] * STEPS
    assert table["step"] == [*range(STEPS)] * 3
    assert table["t"][:3] == [0.0, 0.05, 0.1]
    for column, get in {
        "obs.joint_positions": lambda one: one.observations["joint_positions"][:-1],
        "action.joint_targets": lambda one: one.actions["joint_targets"],
        "reward": lambda one: one.rewards,
        "done": lambda one: one.dones,
        "statuses": lambda one: one.statuses,
    }.items():
        np.testing.assert_array_equal(table[column], np.concatenate([get(one) for one in store]))
    sentences = [IDENTITY["task"], "pick the red cube up", IDENTITY["task"]]
    assert table["task"] == [text for text in sentences for _ in range(STEPS)]
    assert table["leaf"] == [leaf for one in store for leaf in one.leaves]
    image = table["obs.overview_rgb"][0]
    assert image[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", image[16:24]) == (12, 8)
    metadata = parquet.read_schema(path).metadata
    assert json.loads(metadata[b"bt_manip"])["tree"] == "pick"
