"""The packages in plugins/ are installed, and are used like any other's."""

import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from bt_manip.plugins import load_plugins

PACKAGES = sorted((Path(__file__).parents[2] / "plugins").glob("*/pyproject.toml"))


@pytest.fixture(scope="module")
def plugins():
    return load_plugins()


@pytest.mark.parametrize("file", PACKAGES, ids=lambda file: file.parent.name)
def test_each_package_is_found_and_brings_something(file, plugins):
    project = tomllib.loads(file.read_text())["project"]
    (name,) = project["entry-points"]["bt_manip"]
    installed = {point.name for point in entry_points(group="bt_manip")}
    assert name in installed, "run make setup again"
    (plugin,) = [p for p in plugins.plugins if p.name == name]
    assert plugin.problem == ""
    assert plugin.version == project["version"]
    assert plugin.provides
