"""One address for each model, wherever it is from."""

import os

import pytest

from bt_manip.models import ModelError, bundled_path, find_model, is_address, load_model


def test_a_bundled_model_goes_by_its_name():
    assert find_model("bundled:cube").path == bundled_path("cube/cube.xml")
    assert find_model("bundled:panda/panda.xml").path == bundled_path("panda/panda.xml")


def test_a_file_is_what_its_name_or_its_content_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    files = {"a.sdf": ("sdf", ""), "a.urdf": ("urdf", ""), "a.STL": ("mesh", ""),
             "b.xml": ("mjcf", "<mujoco/>"), "c.xml": ("urdf", "<robot/>"),
             "d.xml": ("sdf", "<sdf/>")}  # fmt: skip
    for name, (kind, text) in files.items():
        (tmp_path / name).write_text(text)
        for address in (name, f"./{name}", str(tmp_path / name), f"file://{tmp_path / name}"):
            found = find_model(address)
            assert (found.format, found.address) == (kind, str((tmp_path / name).resolve()))


def test_a_folder_of_gazebo_is_a_model(tmp_path):
    (tmp_path / "my ball").mkdir()
    (tmp_path / "my ball" / "model.config").write_text("<model><sdf>m.sdf</sdf></model>")
    (tmp_path / "my ball" / "m.sdf").write_text("<sdf/>")
    assert find_model(str(tmp_path / "my ball")).name == "my_ball"


def test_a_file_with_a_colon_in_its_name_is_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "odd:name.urdf").touch()
    assert find_model("odd:name.urdf").format == "urdf"


@pytest.mark.parametrize("text", ["cube", "push_button", "my-thing", "Wood2"])
def test_a_plain_name_is_no_address(text):
    assert not is_address(text)


@pytest.mark.parametrize(
    "text", ["fuel:a/b", "bundled:cube", "a/b", "a.sdf", "./a", "menagerie:x", "https://x/y"]
)
def test_what_has_more_than_a_names_characters_is_an_address(text):
    assert is_address(text)


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("menagrie:franka", "unknown kind of address 'menagrie:'; did you mean 'menagerie:'?"),
        ("ftp://x/y.sdf", "unknown kind of address 'ftp:'; "),
        ("bundled:tabel", "no bundled model 'tabel'; did you mean 'table'"),
        ("bundled:../secret", "no bundled"),
        ("", "there is no such file|folder without"),
        ("nobody.sdf", "there is no such file"),
        ("https://example.com/x.sdf", "is not the address of a model"),
    ],
)
def test_a_wrong_address_is_one_clear_error(address, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ModelError) as caught:
        find_model(address)
    assert any(word in str(caught.value) for word in words.split("|"))
    assert os.listdir(tmp_path) == []


def test_meshes_collide_by_hull_or_parts_and_by_nothing_else(tmp_path):
    with pytest.raises(ModelError, match="not by 'sphere'"):
        load_model("bundled:cube", convex="sphere")
