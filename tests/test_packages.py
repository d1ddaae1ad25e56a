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


def test_a_command_names_the_package(capfd):
    assert run_app(Interrupt(), ["--block", "learn", "demos", "pick_place"]) == 2
    install = "'demos' needs the package bt-manip-learn: pip install ./plugins/bt-manip-learn"
    assert install in capfd.readouterr().err


@pytest.mark.parametrize(
    ("former", "new", "package"),
    [
        ("groot", "bt_manip_groot", "bt-manip-groot"),
        ("agents", "bt_manip_learn.agents", "bt-manip-learn"),
        ("demonstrations", "bt_manip_learn.demonstrations", "bt-manip-learn"),
        ("envs", "bt_manip_learn.envs", "bt-manip-learn"),
        ("robot_setup", "bt_manip_setup", "bt-manip-setup"),
    ],
)
def test_the_import_of_a_former_module_names_the_new_one_and_its_package(former, new, package):
    message = f"bt_manip.{former} is now {new}, and needs the package {package}: pip install ./pl"
    with pytest.raises(ImportError, match=message):
        importlib.import_module(f"bt_manip.{former}")
    assert MovedModules.find_spec("bt_manip.nothing") is None
