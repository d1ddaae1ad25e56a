"""Whoever asks for what a package brings that is not installed is told its name."""

import importlib

import pytest

from bt_manip.cli.app import run_app
from bt_manip.cli.interrupt import Interrupt
from bt_manip.packages import MovedModules

INSTALL = "needs the package bt-manip-groot: pip install ./plugins/bt-manip-groot"


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "pick_place", "--groot"],
        ["run", "pick_place", "--groot-port", "1667"],
        ["view", "--groot"],
        ["run", "pick_place", "--record", "run.btlog"],
        ["run", "pick_place", "--record", "db3=run.db3"],
        ["export", "run.mcap", "--to", "btlog"],
    ],
    ids=" ".join,
)
def test_options_and_formats_name_the_package(arguments, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_app(Interrupt(), [*arguments, "--block", "groot"]) == 2
    assert INSTALL in capfd.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "pick_place", "--view"],
        ["run", "pick_place", "--view-port", "0"],
        ["view"],
        ["replay", "run.mcap"],
        ["report", "run.json"],
        ["run", "pick_place", "--record", "run.mp4"],
        ["run", "pick_place", "--record", "video=run.mp4"],
        ["export", "run.mcap", "--to", "gif"],
    ],
    ids=" ".join,
)
def test_commands_name_the_package_too(arguments, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BT_MANIP_BLOCK", "view")
    assert run_app(Interrupt(), arguments) == 2
    message = "needs the package bt-manip-view: pip install ./plugins/bt-manip-view"
    assert message in " ".join(capfd.readouterr().err.split())


@pytest.mark.parametrize(
    ("former", "new", "package"),
    [
        ("groot", "bt_manip_groot", "bt-manip-groot"),
        ("agents", "bt_manip_learn.agents", "bt-manip-learn"),
        ("demonstrations", "bt_manip_learn.demonstrations", "bt-manip-learn"),
        ("envs", "bt_manip_learn.envs", "bt-manip-learn"),
        ("viewer.page", "bt_manip_view.page", "bt-manip-view"),
        ("viewer.html", "bt_manip_view.html", "bt-manip-view"),
        ("record.video", "bt_manip_view.video", "bt-manip-view"),
    ],
)
def test_the_import_of_a_former_module_names_the_new_one_and_its_package(former, new, package):
    message = f"bt_manip.{former} is now {new}, and needs the package {package}: pip install ./pl"
    with pytest.raises(ImportError, match=message):
        importlib.import_module(f"bt_manip.{former}")
    assert MovedModules.find_spec("bt_manip.nothing") is None


@pytest.mark.parametrize(
    ("module", "name"),
    [("viewer", "Page"), ("record", "VideoRecorder"), ("evaluation", "results_page")],
)
def test_a_name_that_has_moved_names_the_new_one_and_its_package(module, name):
    message = f"bt_manip.{module}.{name} is now bt_manip_view.{name}, and needs the package bt-man"
    with pytest.raises(ImportError, match=message):
        exec(f"from bt_manip.{module} import {name}")
