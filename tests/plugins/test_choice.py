"""A user chooses which plugins are loaded, and from where."""

import os
from importlib.metadata import entry_points
from pathlib import Path
from types import SimpleNamespace

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.plugins import PluginSelection, load_plugins
from bt_manip.plugins.entry_points import installed, label_of, names_of


def test_environment_variables_hold_names_and_folders_to_which_options_add(monkeypatch):
    for name in ("BT_MANIP_BLOCK", "BT_MANIP_PLUGINS_DIR"):
        monkeypatch.delenv(name, raising=False)
    assert PluginSelection.from_environment() == PluginSelection()
    monkeypatch.setenv("BT_MANIP_BLOCK", "toys, arms\tpaint")
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", f"a{os.pathsep}b")
    choice = PluginSelection.from_environment()
    assert choice == PluginSelection(frozenset({"toys", "arms", "paint"}), (Path("a"), Path("b")))
    more = choice.extended(["nets", ""], [Path("a"), Path("c")])
    assert more == PluginSelection(choice.blocked | {"nets"}, (*choice.folders, Path("c")))


def test_a_blocked_plugin_is_not_imported_and_its_absence_is_explained(plugin, load):
    point = plugin("toys", "raise SystemExit")
    warnings: list[str] = []
    plugins = load_plugins(
        entry_points=[point], warn=warnings.append, choice=PluginSelection(frozenset({"toys"}))
    )
    assert warnings == []
    assert plugins.plugins[1].status == "blocked"
    with pytest.raises(BtManipError, match=r"unknown object 'ball'.*\(blocked: plugin 'toys'\)"):
        plugins.parts.objects.get("ball")


def test_a_plugin_is_blocked_by_its_own_name_or_its_packages():
    point = SimpleNamespace(name="arms", dist=SimpleNamespace(name="bt_manip_Menagerie"))
    assert names_of(point) == {"arms", "bt_manip_Menagerie", "bt-manip-menagerie", "menagerie"}


def test_the_built_in_plugin_cannot_be_blocked(load):
    plugins = load_plugins(entry_points=(), choice=PluginSelection(frozenset({"builtin"})))
    assert "cube" in plugins.parts.objects


def test_each_file_of_a_folder_is_a_plugin_and_shadows_no_module(tmp_path):
    head = "from bt_manip import hookimpl\n@hookimpl\n"
    for name in ("tree", "numpy"):  # names that others have, and dm_control needs
        code = f"{head}def register_objects(register): register('of_{name}', dict)\n"
        (tmp_path / f"{name}.py").write_text(code)
    for name in ("_private.py", "test_it.py", "it_test.py", "conftest.py"):
        (tmp_path / name).write_text("raise RuntimeError")
    (tmp_path / "notes.txt").write_text("nothing")
    plugins = load_plugins(entry_points=(), choice=PluginSelection(folders=(tmp_path,)))
    assert [p.name for p in plugins.plugins] == ["builtin", "numpy", "tree"]
    assert plugins.parts.objects.owner("of_tree") == "tree"
    assert plugins.plugins[2].source == str(tmp_path / "tree.py")
    import numpy as np

    assert np.zeros(1) == 0.0


def test_a_file_that_fails_leaves_no_module_behind(tmp_path):
    import sys

    (tmp_path / "half.py").write_text("x = 1\nraise RuntimeError('no')\n")
    load_plugins(entry_points=(), warn=print, choice=PluginSelection(folders=(tmp_path,)))
    assert not [name for name in sys.modules if "half" in name]


def test_a_folder_that_is_not_there_is_bad_input(tmp_path):
    with pytest.raises(BtManipError, match="no folder"):
        load_plugins(entry_points=(), choice=PluginSelection(folders=(tmp_path / "nowhere",)))


def test_installed_plugins_are_those_of_importlib_metadata():
    points = entry_points(group="bt_manip")
    known = {(p.name, p.value, p.dist.name, p.dist.version) for p in points}
    found = installed()
    assert {(p.name, p.value, *label_of(p).split()) for p in found} == known
    assert {p.dist.name for p in found} == {name for _, _, name, _ in known}
    assert {p.load() for p in found} == {p.load() for p in points}


def test_entry_points_are_read_by_group_and_hidden_by_the_first_package_of_a_name(
    tmp_path, monkeypatch
):
    for place, name, value in (("one", "Gear_Box", "box:a.b"), ("two", "gear-box", "other")):
        info = tmp_path / place / f"{name}-1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        points = f"[console_scripts]\ngear = no:main\n\n# ours\n[bt_manip]\ngear = {value}\n"
        (info / "entry_points.txt").write_text(points)
    monkeypatch.setattr("sys.path", [str(tmp_path / "one"), str(tmp_path / "two"), "nowhere"])
    (point,) = installed()
    assert (point.name, point.value, point.module) == ("gear", "box:a.b", "box")
    assert names_of(point) == {"gear", "Gear_Box", "gear-box"}
    assert installed("bt_manip.commands") == ()
