"""A pose source may bring a believed cell: the tree gets it, the physics goes on and judges."""

from dataclasses import replace

import pytest

from bt_manip.bt import NodeStatus, Tree
from bt_manip.bt.nodes import Action, Condition
from bt_manip.cell import Cell
from bt_manip.runner import Believed, Run, RunLoop, RunRequest, TreeSource, make_station
from bt_manip.scenes import ExpectedObjects, PoseSource, Scene, SceneObject, SceneRobot
from bt_manip.spatial import pose


class Empty(Believed):
    """A cell without anything, whose robots are those of the physics."""

    def __init__(self, *, scene, robots, cell, source, catalogue, **others):
        self.expected = [one.name for one in scene.objects if one.expected]
        self.cell, self.robots, self.physics = Cell(), robots, cell
        self.poses = ExpectedObjects(source, self.cell, catalogue)
        self.cycles = self.measured = self.followed = self.state = 0

    def begin(self):
        self.cycles += 1

    def measure(self):
        self.measured += 1

    def follow(self, steps):
        assert self.measured == self.followed + steps
        self.followed += steps

    def get_state(self):
        return {"state": self.state}

    def set_state(self, state, make):
        self.state = state["state"]


class Seen(PoseSource):
    believed_cell = Empty

    def pose(self, scene_object, T_wo):
        return None


class Watch(Action):
    """Takes five ticks."""

    def setup(self, **infrastructure):
        self.given, self.ticks = infrastructure, 0

    def update(self):
        self.ticks += 1
        return NodeStatus.SUCCESS if self.ticks == 5 else NodeStatus.RUNNING


class Judge(Condition):
    def setup(self, **infrastructure):
        self.given = infrastructure

    def update(self):
        return NodeStatus.SUCCESS if "cube" in self.given["cell"].entities else NodeStatus.FAILURE


CUBE = SceneObject("cube", "cube", pose((0.4, 0.0, 0.025)), free=True, expected=True)
SCENE = Scene((SceneRobot(pose((0.0, 0.0, 0.0))),), (CUBE,))


@pytest.fixture
def with_seen(parts):
    return replace(parts, pose_sources=parts.pose_sources.with_part("seen", Seen))


def request_for(**options):
    return RunRequest(TreeSource("test", "python"), scene=SCENE, poses="seen", **options)


def test_the_tree_gets_the_believed_cell_and_the_goal_the_physics(with_seen):
    station = make_station(request_for(), with_seen)
    believed = station.believed
    assert believed.expected == ["cube"] and "cube" in station.cell.entities
    watch, judge = Watch(), Judge()
    tree = Tree(watch, clock=station.clock, goal=judge)
    tree.setup(**station.infrastructure)
    assert watch.given["cell"] is believed.cell and watch.given["poses"] is believed.poses
    assert "judged" not in watch.given
    assert judge.given["cell"] is station.cell and judge.given["poses"] is None
    with RunLoop(Run(station.request, tree, station)) as loop:
        ended = loop.cycle()
    assert ended.succeeded
    assert believed.cycles == 2  # once when it was built
    assert believed.followed == believed.measured == round(station.cell.time / station.cell.dt)


def test_a_goal_that_only_the_believed_cell_meets_is_not_met(with_seen):
    station = make_station(request_for(), with_seen)
    station.believed.state = 7
    state = station.get_state()
    station.believed.state = 8
    station.set_state(state)
    assert station.believed.state == 7  # it is a part of the station's
    station.believed.cell.add(station.cell.remove("cube"), pose((0.4, 0.0, 0.1)), name="cube")
    result = station.run(Tree(Watch(), goal=Judge()))
    assert (result.status, result.reason[:14]) == (NodeStatus.FAILURE, "goal not met: ")


def test_sensors_are_those_of_the_physics(parts):
    camera = SceneObject("camera", "eye", pose((0.0, 0.0, 1.0)))
    scene = replace(SCENE, objects=(camera,))
    station = make_station(RunRequest(TreeSource("test", "python"), scene=scene), parts)
    assert station.infrastructure["sensors"] == {"eye": station.cell.find("eye")}
