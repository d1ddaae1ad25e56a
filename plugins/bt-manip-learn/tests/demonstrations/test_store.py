"""A folder of demonstrations holds whole episodes of one identity."""

import json

import h5py
import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip_learn.demonstrations import DemonstrationStore, read_demonstrations

from .conftest import IDENTITY


def test_a_demonstration_is_read_as_it_was_written(store, make_demonstration):
    read = store.read(1)
    np.testing.assert_equal(vars(read), vars(make_demonstration(1)))
    assert (read.dones.dtype, read.statuses.dtype) == (bool, np.uint8)


def test_iterating_leaves_out_failed_episodes_without_steps_and_unfinished_files(store):
    (store.folder / ".episode_000004.h5.1a2b3c4d.part").write_bytes(b"half of it")
    assert store.episodes() == [0, 1, 2, 3]
    assert [one.episode for one in read_demonstrations(store.folder)] == [0, 1, 3]
    assert not store.read(2).success
    assert store.read(2).reason == "pick/Grasp: it slipped"


def test_the_same_demonstration_gives_the_same_bytes_with_each_image_compressed(
    store, make_demonstration
):
    before = store.path(1).read_bytes()
    store.write(make_demonstration(1))
    assert store.path(1).read_bytes() == before
    with h5py.File(store.path(1)) as file:
        images = file["observations/overview_rgb"]
        assert (images.chunks, images.compression) == ((1, *images.shape[1:]), "gzip")
        for name in ("statuses", "observations/cube_position"):
            assert (file[name].chunks, file[name].compression) == (None, None)


def test_the_manifest_has_the_outcome_of_each_episode(store):
    store.write_outcomes()
    manifest = json.loads((store.folder / "manifest.json").read_text())
    assert manifest["tree"] == "pick"
    outcomes = manifest["episodes"]
    found = [(one["episode"], one["success"], one["steps"]) for one in outcomes]
    assert found == [(0, True, 5), (1, True, 5), (2, False, 0), (3, True, 5)]
    assert outcomes[1]["digest"] == store.read(1).digest


def test_a_folder_is_opened_again_with_the_same_identity_only(store):
    store.write_outcomes()
    assert DemonstrationStore.create(store.folder, IDENTITY).episodes() == [0, 1, 2, 3]
    with pytest.raises(BtManipError, match="that differ: tree 'pick' instead of"):
        DemonstrationStore.create(store.folder, {**IDENTITY, "tree": "place"})


def test_a_file_of_another_recording_is_refused(store, make_demonstration, tmp_path):
    other = DemonstrationStore.create(tmp_path / "other", {**IDENTITY, "tree": "place"})
    other.write(make_demonstration(7))
    store.path(7).write_bytes(other.path(7).read_bytes())
    for use in (
        lambda: DemonstrationStore.create(store.folder, IDENTITY),
        lambda: list(read_demonstrations(store.folder)),
        store.write_outcomes,
    ):
        with pytest.raises(BtManipError, match="episode_000007.h5' is of another recording"):
            use()


def test_a_small_file_that_claims_huge_arrays_is_refused(store):
    with h5py.File(store.path(1), "a") as file:
        file.create_dataset("observations/huge", shape=(2**40,), dtype="f4", chunks=True)
    assert store.path(1).stat().st_size < 2**20
    with pytest.raises(BtManipError, match="has arrays of 4096 GB, at most 4 GB are read"):
        store.read(1)


def test_other_folders_and_files_are_refused_with_the_reason(store, tmp_path):
    with pytest.raises(BtManipError, match="cannot be read: No such file"):
        read_demonstrations(tmp_path)
    with pytest.raises(BtManipError, match="holds other files: choose an empty folder"):
        DemonstrationStore.create(tmp_path, IDENTITY)
    store.path(1).write_bytes(b"not HDF5")
    with pytest.raises(BtManipError, match="demonstration '.*episode_000001.h5' cannot be read"):
        store.read(1)
    manifest = store.folder / "manifest.json"
    manifest.write_text('{"format": "bt-manip demonstrations"}')
    for size, problem in ((0, "is not a manifest"), (64, "is not a manifest"), (65, "larger than")):
        with manifest.open("ab") as file:
            file.truncate(max(size << 20, manifest.stat().st_size))  # [MiB] of zeros
        with pytest.raises(BtManipError, match=problem):
            read_demonstrations(store.folder)
