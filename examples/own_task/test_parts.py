"""Tests of the task: ``pytest examples/own_task``."""

from pathlib import Path

import pytest

import bt_manip
from bt_manip.bt import NodeStatus
from bt_manip.plugins import load_plugins
from bt_manip.spatial import pose

FOLDER = Path(__file__).parent
CHOOSE = {"left_objects": "kind:nut", "right_objects": "cube;block", "object": "{o}", "bin": "{b}"}


@pytest.fixture(scope="session")
def parts():
    """The registered parts, with those of this folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BT_MANIP_PLUGINS_DIR", str(FOLDER))
        return load_plugins().parts


@pytest.fixture(scope="session")
def build_station(parts):
    """Build the station of the scene in this folder."""
    return lambda: bt_manip.build_station(parts, scene=str(FOLDER / "scene.toml"))


@pytest.fixture
def choose(parts, trial):
    """Tick the choice once; return its status, the object and its bin."""

    def choose():
        chosen = trial(parts.behaviours.get("ChooseNext")(**CHOOSE))
        status = chosen.tick()
        return status, *(chosen.tree.blackboard.get(key) for key in "ob")

    return choose


def test_nuts_come_first(choose):
    """The first of all objects is a nut."""
    assert choose() == (NodeStatus.SUCCESS, "nut_1", "left_bin")


def test_the_next_object_is_in_neither_bin(station, choose):
    """With both nuts in the left bin, the cube is next."""
    for i in (1, 2):
        station.cell.move(f"nut_{i}", pose((0.18 + 0.08 * i, 0.4, 1.06)))
    station.cell.step(1000)
    assert choose() == (NodeStatus.SUCCESS, "cube", "right_bin")


def test_a_nut_lies_flat(station):
    """Its axis stays vertical."""
    station.cell.step(500)
    for name in ("nut_1", "nut_2"):
        assert station.cell.pose(name).rotation[2, 2] > 0.999


def test_each_object_of_the_goal_has_its_bin(trial):
    """The pattern of the goal stands for both nuts."""
    goal = trial("sort.xml").tree.goal
    pairs = [(one.object, one.container) for one in goal]
    assert pairs == [
        ("nut_1", "left_bin"), ("nut_2", "left_bin"), ("cube", "right_bin"), ("block", "right_bin"),
    ]  # fmt: skip
