"""One address for each model, wherever it is from."""

import os

import numpy as np
import pytest
import trimesh

from bt_manip.cell.objects import ModelObject
from bt_manip.exceptions import BtManipError
from bt_manip.models import (
    MjcfModel,
    ModelError,
    ModelFormat,
    address,
    built_in_sources,
    bundled_path,
    find_model,
    is_address,
    load_model,
)
from bt_manip.registry import Parts


def test_a_file_is_what_its_name_or_its_content_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    files = {"a.urdf": ("urdf", ""), "a.STL": ("mesh", ""),
             "b.xml": ("mjcf", "<mujoco/>"), "c.xml": ("urdf", "<robot/>")}  # fmt: skip
    for name, (kind, content) in files.items():
        (tmp_path / name).write_text(content)
        for text in (name, f"./{name}", str(tmp_path / name), f"file://{tmp_path / name}"):
            found = find_model(text)
            assert (found.format, found.address) == (kind, str((tmp_path / name).resolve()))
    (tmp_path / "odd:name.urdf").touch()
    assert find_model("odd:name.urdf").format == "urdf"


def test_models_of_fuel_and_sdf_name_the_package_that_reads_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BT_MANIP_BLOCK", "fuel")
    for name in ("a.sdf", "a.world", "b.xml"):
        (tmp_path / name).write_text("<sdf/>")
    (tmp_path / "ball").mkdir()
    (tmp_path / "ball" / "model.config").touch()
    for given in ("fuel:a/b", "https://x/y", "a.sdf", "a.world", "b.xml", "ball"):
        words = f"^'{given}' needs the package .*pip install ./plugins/bt-manip-fuel"
        with pytest.raises(ModelError, match=words):
            load_model(given)


def test_sources_and_formats_of_installed_plugins_are_the_default(tmp_path, monkeypatch):
    ball = ModelFormat(
        lambda found, *, convex, progress: MjcfModel(found.address, found.name, xml="<mujoco/>"),
        suffixes=(".ball",),
    )
    (tmp_path / "red.ball").touch()
    (tmp_path / "plugin.py").write_text("")
    parts = Parts()
    parts.model_formats.add("ball", ball, "test")
    parts.model_sources.add("shelf", lambda address, progress: tmp_path / "red.ball", "test")
    monkeypatch.setattr(address, "installed_parts", lambda: parts)
    assert load_model(str(tmp_path / "red.ball")).xml == "<mujoco/>"
    assert load_model("shelf:red").address == "shelf:red"
    with pytest.raises(ModelError, match="not a model"):
        find_model(str(tmp_path / "plugin.py"))
    with pytest.raises(ModelError, match="unknown kind of address 'shelf:'"):
        find_model("shelf:red", sources=built_in_sources())


def test_models_of_built_in_sources_and_formats_load_no_plugins(tmp_path, monkeypatch):
    monkeypatch.setattr(address, "installed_parts", lambda: pytest.fail("plugins were loaded"))
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "box.stl")
    assert "mesh" in load_model(str(tmp_path / "box.stl")).xml
    assert load_model("bundled:cube").path == bundled_path("cube/cube.xml")
    assert find_model("bundled:panda/panda.xml").path == bundled_path("panda/panda.xml")
    with pytest.raises(BtManipError, match="did you mean 'panda/panda.xml'"):
        bundled_path("panda/pnda.xml")
    with pytest.raises(ModelError, match="did you mean 'box.stl'"):
        find_model(str(tmp_path / "box.sdl"))


def test_a_plain_name_is_no_address_and_what_has_more_characters_is_one():
    names = ("cube", "push_button", "my-thing", "Wood2")
    addresses = ("fuel:a/b", "a/b", "a.sdf", "./a", "https://x/y")
    assert [is_address(text) for text in (*names, *addresses)] == [False] * 4 + [True] * 5


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("menagrie:franka", "unknown kind of address 'menagrie:'; did you mean 'menagerie:'?"),
        ("ftp://x/y.urdf", "unknown kind of address 'ftp:'; "),
        ("bundled:tabel", "no bundled model 'tabel'; did you mean 'table'"),
        ("bundled:../secret", "no bundled"),
        ("", "there is no such file|folder without"),
        ("nobody.urdf", "there is no such file"),
        ("package://nobody/x.urdf", "no package 'nobody'"),
        ("text.txt", "not a model; one is"),
        ("holed.stl", "not watertight"),
        ("wrong.xml", "cannot be read"),
    ],
)
def test_a_wrong_address_is_one_clear_error(address, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.txt").touch()
    (tmp_path / "wrong.xml").write_text(
        "<mujoco><worldbody><geom type='bal'/></worldbody></mujoco>"
    )
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    box.update_faces(np.arange(10))
    box.export(tmp_path / "holed.stl")
    with pytest.raises(BtManipError) as caught:
        ModelObject(address)
    assert any(word in str(caught.value) for word in words.split("|"))
    assert len(str(caught.value).splitlines()) == 1 and len(os.listdir(tmp_path)) == 3
