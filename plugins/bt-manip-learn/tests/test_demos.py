"""``bt-manip demos``: the folder that it writes, resuming, and its exports."""

import json

import h5py
import pytest

from bt_manip_learn.demonstrations import read_demonstrations


@pytest.fixture
def record(bt_manip, small_trees, tmp_path):
    folder = tmp_path / "demos"
    return lambda *options, name="tree": bt_manip(
        "demos", f"{small_trees}:{name}", "--to", folder, "--workers", 1, *options
    )


def digests(folder):
    manifest = json.loads((folder / "manifest.json").read_text())
    return {one["episode"]: one["digest"] for one in manifest["episodes"]}


def test_episodes_are_recorded_and_exported(record, bt_manip, tmp_path):
    folder = tmp_path / "demos"
    code, out, err = record("--episodes", 2)
    assert (code, err) == (0, "")
    assert out == f"{folder}: 2 of 2 succeeded, 12 steps\n"
    assert [one.episode for one in read_demonstrations(folder)] == [0, 1]
    for form, groups in (("parquet", "all"), ("robomimic", "all"), ("robomimic", "robot")):
        file = tmp_path / f"{form}-{groups}"
        words = "--format", form, "-o", file, "--observations", groups
        code, out, err = bt_manip("demos", "export", folder, *words)
        assert (code, out, err) == (0, f"{file}: 2 demonstrations\n", "")
    with h5py.File(tmp_path / "robomimic-all") as file:
        assert file["data"].attrs["total"] == 12  # the goal holds after the first; five more
        assert "cube_position" in file["data/demo_0/obs"]
    with h5py.File(tmp_path / "robomimic-robot") as file:
        assert {name.partition("_")[0] for name in file["data/demo_0/obs"]} == {"robot"}
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["task"] == "tree"


def test_the_same_command_continues_and_others_are_refused(record, tmp_path, in_this_process):
    folder = tmp_path / "demos"
    assert record("--episodes", 1).code == 0
    first = digests(folder)
    written = (folder / "episode_000000.h5").stat().st_mtime_ns
    assert record("--episodes", 2).code == 0
    assert digests(folder).items() > first.items()
    assert (folder / "episode_000000.h5").stat().st_mtime_ns == written
    code, _, err = record("--episodes", 2, "--seed", 7)
    assert code == 2 and "holds demonstrations that differ: seed 0 instead of 7: choose" in err


def test_a_folder_is_recorded_by_one_process_at_a_time(record, tmp_path, in_this_process):
    assert record("--episodes", 1).code == 0
    store = read_demonstrations(tmp_path / "demos")
    with store.recording():
        code, out, err = record("--episodes", 2)
        assert (code, out) == (2, "") and store.episodes() == [0]
        assert err == f"Error: '{store.folder}' is being recorded by another process\n"
        assert [one.episode for one in store] == [0]
    assert {path.name for path in store.folder.iterdir()} == {"manifest.json", "episode_000000.h5"}


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("aimless", "the cell has no object 'never'"),
        ("leaving", "its process ended with exit code 0"),
    ],
)
def test_failed_episodes_are_named_with_the_reason(record, name, reason):
    code, out, err = record("--episodes", 1, name=name)
    assert (code, err) == (1, "")
    assert out.startswith(f"episode 0 failed: {reason}\n")
    assert out.endswith("0 of 1 succeeded, 0 steps\n")


def test_a_tree_that_ends_its_process_before_it_moves_is_refused(record):
    code, out, err = record("--episodes", 1, name="gone")
    assert (code, out) == (3, "")
    assert err == "Error: the first episode: its process ended with exit code 0\n"


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("--images", "overvew"), "Error: there is no camera 'overvew'"),
        (("--images", "overview", "--size", "big"), "Error: size is WIDTHxHEIGHT"),
        (("--robot", "pand"), "Error: unknown robot 'pand'; did you mean 'panda'"),
        (("--episodes", "0"), "Invalid value for '--episodes'"),
    ],
)
def test_bad_input_is_one_line_and_leaves_no_folder(
    record, in_this_process, tmp_path, options, problem
):
    code, out, err = record(*options)
    assert code == 2 and problem in err and out == ""
    assert not (tmp_path / "demos").exists()


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ("lerobot -o x", "--python belongs to --format lerobot"),
        ("parquet -o /nowhere/x", "Error: export '/nowhere/x' cannot be written"),
        ("hdf5 -o x", "Invalid value for '--format'"),
    ],
)
def test_bad_exports_are_refused(bt_manip, tmp_path, options, problem):
    manifest = {"format": "bt-manip demonstrations", "version": 1}
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    code, out, err = bt_manip("demos", "export", tmp_path, "--format", *options.split())
    assert code == 2 and problem in err and out == ""


def test_the_commands_have_the_options_of_all_commands(bt_manip, record, in_this_process):
    for command in ("demos", "demos record", "demos export"):
        assert "--block NAME" in bt_manip(*command.split(), "--help").out
    code, _, err = record("--robot", "pand", "--block", "nobody")
    assert code == 2 and "--block nobody: there is no such plugin" in err
