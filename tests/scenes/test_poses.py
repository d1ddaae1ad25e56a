"""Objects that a scene expects, and the sources of their poses."""

import os

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.behaviours import RemoveObject, SpawnObject
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import CellError
from bt_manip.exceptions import BtManipError
from bt_manip.scenes import OperatorPoses, PoseSource, SceneError, read_scene
from bt_manip.spatial import pose

SCENE = """
robots = [{name = "arm", position = [-0.1, 0.0, 1.015]}]
[[objects]]
model = "table"
[[objects]]
model = "cube"
name = "first"
on = "table"
position = [0.3, 0.1]
expected = true
[[objects]]
model = "can"
name = "second"
on = "table"
position = [0.3, -0.2]
expected = true
"""
RUNNING, SUCCESS, FAILURE = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE


@pytest.fixture
def scene(write):
    return str(write(SCENE))


class Late(PoseSource):
    """Sees an object a little beside its place, at the second look."""

    def __init__(self, expected):
        super().__init__(expected)
        self.looks, self.gone = 0, []

    def pose(self, fixture, T_wo):
        self.looks += 1
        return None if self.looks % 2 else pose((0.01, 0.0, 0.0)) * T_wo

    def taken(self, name):
        self.gone.append(name)


@pytest.fixture
def station(parts, scene):
    station = build_station(parts, scene=scene, poses="scene")
    station.poses.source = Late(station.poses.source.expected)
    return station


def ticks(station, node):
    tree = Tree(node, clock=station.clock)
    tree.setup(**station.infrastructure)
    status = RUNNING
    while status is RUNNING:
        status = tree.tick()
        station.cell.step(10)
        yield status
    yield tree


def test_an_expected_object_is_in_the_cell_once_its_pose_is_known_until_it_is_taken_away(station):
    before = station.get_state()
    assert "first" not in station.cell.entities
    *statuses, tree = ticks(station, SpawnObject(object="{object}", pose="{pose}"))
    assert statuses == [RUNNING, SUCCESS]
    assert tree.blackboard.get("object") == "first"
    found = station.cell.pose("first").translation
    np.testing.assert_allclose(found, [0.31, 0.1, 1.04], atol=1e-3)
    list(ticks(station, RemoveObject(object="first")))
    assert station.poses.source.gone == ["first"]
    station.set_state(before)
    *_, tree = ticks(station, SpawnObject(object="{object}"))
    assert tree.blackboard.get("object") == "first"


def test_the_next_object_of_a_model_is_taken_once(station):
    *_, tree = ticks(station, SpawnObject(model="can", object="{object}"))
    assert tree.blackboard.get("object") == "second"
    *statuses, tree = ticks(station, SpawnObject(model="can", object="{object}"))
    assert statuses == [FAILURE]
    assert "expects no further 'can'" in tree.failure_reason()


def test_an_operator_confirms_after_the_question(parts, scene, capsys, monkeypatch):
    expected = [f for f in read_scene(scene, parts).objects if f.expected]
    reading, writing = os.pipe()
    with os.fdopen(reading) as stream, os.fdopen(writing, "wb", buffering=0) as answers:
        monkeypatch.setattr("sys.stdin", stream)
        operator = OperatorPoses(expected)
        answers.write(b"\n")  # too early
        place = pose((0.3, 0.1, 1.04))
        assert operator.pose(expected[0], place) is None
        assert capsys.readouterr().out == (
            "Put 'first' (cube) at 0.300 0.100 1.040 [m], then press Enter.\n"
        )
        assert operator.pose(expected[0], place) is None
        answers.write(b"\n")
        assert operator.pose(expected[0], place) is place
        assert operator.pose(expected[1], place) is None
        answers.close()
        with pytest.raises(CellError, match="nobody can confirm 'second'"):
            operator.pose(expected[1], place)


def test_a_source_needs_a_name_and_expected_objects_with_positions(parts, scene, write):
    with pytest.raises(BtManipError, match="unknown pose source 'scen'; did you mean 'scene'"):
        build_station(parts, scene=scene, poses="scen")
    with pytest.raises(BtManipError, match="needs a scene that expects objects"):
        build_station(parts, poses="scene")
    region = "region = {x = [0.1, 0.2], y = [0.1, 0.2]}"
    with pytest.raises(SceneError, match="region' and 'expected' exclude each other"):
        read_scene(write(SCENE.replace("position = [0.3, 0.1]", region)))
