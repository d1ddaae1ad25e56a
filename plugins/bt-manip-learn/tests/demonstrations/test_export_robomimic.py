"""The HDF5 file has the layout that robomimic reads."""

import json

import h5py
import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn.demonstrations import DemonstrationStore, write_robomimic

from .conftest import IDENTITY, STEPS


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


def test_parts_that_differ_between_robots_are_left_to_the_scene(store, tmp_path):
    del store.manifest["request"]  # as in older manifests
    path = tmp_path / "demos.hdf5"
    write_robomimic(store, path, "joint_targets")
    with h5py.File(path) as file:
        kwargs = json.loads(file["data"].attrs["env_args"])["env_kwargs"]
    assert "robot" not in kwargs and kwargs["planner"] == "lazy"


def test_observations_that_only_a_simulator_knows_can_be_left_out(store, tmp_path):
    path = tmp_path / "demos.hdf5"
    write_robomimic(store, path, "joint_targets", "robot")
    with h5py.File(path) as file:
        assert sorted(file["data/demo_0/obs"]) == ["joint_positions", "overview_rgb"]
    del store.manifest["observations"]["cube_position"]["group"]  # as in older manifests
    assert "cube_position" in store.observed(store.read(0), "robot")
    assert "cube_position" in store.observed(store.read(0), "all")


def test_labels_and_all_kinds_of_actions_are_kept(store, tmp_path):
    path = tmp_path / "demos.hdf5"
    write_robomimic(store, path, "joint_targets")
    with h5py.File(path) as file:
        demo, one = file["data/demo_2"], store.read(3)
        np.testing.assert_allclose(demo["actions"], one.actions["joint_targets"] / 4.0, atol=1e-6)
        for kind, array in one.actions.items():
            np.testing.assert_array_equal(demo["action_dict"][kind], array)
        names = [text.decode() for text in file["leaves"]]
        assert tuple(names[i] for i in demo["leaf"]) == one.leaves
        np.testing.assert_array_equal(demo["statuses"], one.statuses)
        assert json.loads(file["manifest"][()])["tree"] == "pick"


def test_masks_split_the_demonstrations_to_train_and_to_validate(tmp_path, make_demonstration):
    store = DemonstrationStore.create(tmp_path / "demos", IDENTITY)
    for episode in range(20):
        store.write(make_demonstration(episode, steps=1))
    masks = []
    for path in (tmp_path / "1.hdf5", tmp_path / "2.hdf5"):
        write_robomimic(store, path, "joint_targets")
        with h5py.File(path) as file:
            masks.append({k: [d.decode() for d in file[f"mask/{k}"]] for k in ("train", "valid")})
            assert sorted(masks[-1]["train"] + masks[-1]["valid"]) == sorted(file["data"])
    assert len(masks[0]["valid"]) == 2
    assert masks[0] == masks[1]


def test_a_wrong_kind_of_actions_and_an_empty_folder_are_refused(store, tmp_path):
    path = tmp_path / "demos.hdf5"
    with pytest.raises(BtManipError, match="no actions 'joint_target', but joint_targets, "):
        write_robomimic(store, path, "joint_target")
    empty = DemonstrationStore.create(tmp_path / "empty", IDENTITY)
    with pytest.raises(BtManipError, match="has no demonstrations to export"):
        write_robomimic(empty, path, "joint_targets")
    assert not path.exists()
