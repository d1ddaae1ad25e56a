"""The packages in plugins/ are installed, and are used like any other's."""

import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell
from bt_manip.plugins import load_plugins
from bt_manip.robots import Robot

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


def test_a_packages_object_and_controller_work_together_by_name(plugins):
    """A compliant arm stands still beside a button that nobody presses."""
    parts = plugins.parts
    robot = Robot(parts.robots.get("panda"))
    robot.attach(parts.controllers.create("joint_impedance", robot))
    cell = Cell()
    cell.add(robot)
    T_wb = pin.SE3(np.eye(3), np.array([0.0, 0.6, 0.0]))
    name = cell.add(parts.objects.create("push_button"), T_wb)
    home = robot.q
    cell.step(100)
    assert parts.objects.owner("push_button") == parts.controllers.owner("joint_impedance")
    assert not cell.entities[name].pressed
    assert abs(robot.q - home).max() < 1e-3
