"""The HDF5 file has the layout that robomimic reads."""

import json

import h5py
import numpy as np

from bt_manip_learn.demonstrations import write_robomimic
from bt_manip_learn.demonstrations.export_robomimic import split

from .conftest import STEPS


def test_each_demonstration_has_what_robomimic_reads(store, tmp_path):
    path = tmp_path / "demos.hdf5"
    assert write_robomimic(store, path, "cartesian_deltas") == 3
    with h5py.File(path) as file:
        data = file["data"]
        assert sorted(data) == ["demo_0", "demo_1", "demo_2"]
        assert data.attrs["total"] == 3 * STEPS
        args = json.loads(data.attrs["env_args"])
        assert (args["env_name"], args["type"]) == ("pick", 2)
        assert args["env_kwargs"] == {
            "tree": "pick",
            "robot": "panda",
            "controller": "computed_torque",
            "planner": "lazy",
            "scene": "table_and_basket",
            "settings": {"cube": "auto"},
            "images": {"kinds": []},
            "tick": 0.05,
            "vary": {"scene.mass": 2},
            "action": "cartesian_deltas",
        }
        for demo, one in zip(("demo_0", "demo_1", "demo_2"), store, strict=True):
            group = data[demo]
            assert group.attrs["num_samples"] == STEPS
            assert group.attrs["episode"] == one.episode
            scaled = np.clip(one.actions["cartesian_deltas"] / 2.0, -1.0, 1.0)
            np.testing.assert_allclose(group["actions"], scaled, atol=1e-6)
            np.testing.assert_array_equal(group["states"], one.states[:-1])
            np.testing.assert_array_equal(group["rewards"], one.rewards)
            np.testing.assert_array_equal(group["dones"], one.dones)
            for name, array in one.observations.items():
                np.testing.assert_array_equal(group["obs"][name], array[:-1])
                np.testing.assert_array_equal(group["next_obs"][name], array[1:])
            for kind, array in one.actions.items():
                np.testing.assert_array_equal(group["action_dict"][kind], array)
            names = [text.decode() for text in file["leaves"]]
            assert tuple(names[i] for i in group["leaf"]) == one.leaves
            np.testing.assert_array_equal(group["statuses"], one.statuses)
        assert json.loads(file["manifest"][()])["tree"] == "pick"
        for name, demos in split(sorted(data)).items():
            assert file[f"mask/{name}"][()].tolist() == [one.encode() for one in demos]


def test_one_demonstration_of_ten_validates():
    names = [f"demo_{i}" for i in range(20)]
    found = split(names)
    assert len(found["valid"]) == 2 and sorted(found["train"] + found["valid"]) == sorted(names)
    assert split(names) == found
    assert len(split(names[:3])["valid"]) == 1
