"""A tree whose episodes take a moment, and succeed, fail or hang by their number's samples."""

import pytest

from bt_manip.evaluation import Evaluation

TREES = """
from bt_manip.behaviours import Grasp, Hover, IsIn, Lift, ObjectExists, Reach, SpawnObject
from bt_manip.bt import (
    Action, AlwaysFailure, Condition, Fallback, Input, Sequence, Sleep, Status, Tree,
)


class IsLight(Condition):
    object = Input(str, doc="Name of the object.")
    limit = Input(float, default=0.1, doc="Largest mass [kg].")

    def setup(self, **infrastructure):
        self.cell = infrastructure["cell"]

    def update(self):
        mass = self.cell.overrides["cube"]["mass"]
        return Status.SUCCESS if mass < self.limit else self.fail(f"{mass:.3f} kg is heavy")


class Shout(Action):
    def update(self):
        raise ValueError("so loud")


class Exit(Action):
    def update(self):
        raise SystemExit


class Diverge(Action):
    limit = Input(float, doc="Largest mass of the cube with which the state stays finite [kg].")

    def setup(self, **infrastructure):
        self.cell = infrastructure["cell"]

    def update(self):
        if self.cell.overrides["cube"]["mass"] > self.limit:
            self.cell.data.qvel[:] = float("nan")
        return Status.SUCCESS


def spawn():
    return SpawnObject(object="{object}")


def light(limit=0.1):
    check = IsLight("check", object="{object}", limit=limit)
    return Tree(Sequence("task", spawn(), Sleep("work", msec=50), check))


def trusting():
    return Tree(Sequence("task", spawn(), Sleep("work", msec=50)), goal=ObjectExists(object="no"))


def endless():
    return Tree(Sequence("task", spawn(), Sleep("wait", msec=10_000_000)))


def pick():
    steps = [kind(object="cube") for kind in (Hover, Reach, Grasp)]
    return Tree(Sequence("pick", *steps, Lift()))


def fragile(limit):
    steps = [kind(object="cube") for kind in (Reach, Grasp)]
    goal = IsIn(object="cube", container="table")
    return Tree(Sequence("pick", *steps, Diverge(limit=limit), Sleep(msec=20)), goal=goal)


class Policy(Action):
    reports_time = True

    def update(self):
        return self.fail("does not fit")


def rescued():
    return Tree(Fallback("or", Policy("policy"), Sleep("script", msec=50)))


def leaving():
    return Tree(Sequence("task", spawn(), Exit("leave")))


def loud():
    return Tree(Sequence("task", spawn(), Shout("shout")))
"""

SCENE = """
seed = 1
[[robots]]
position = [-0.1, 0.0, 1.015]
[[objects]]
model = "table"
[randomization.objects.cube]
mass = { uniform = [0.05, 0.15] }
"""


FIXTURE = """
[[objects]]
model = "cube"
on = "table"
position = [0.45, 0.0]
[randomization.objects.cube]
position = { plus = { uniform = [[-0.1, -0.15, 0.0], [0.1, 0.15, 0.0]] } }
yaw = { uniform = [-0.7, 0.7] }
"""

FIXED = """
[[objects]]
model = "cube"
on = "table"
position = [0.3, 0.0]
[randomization.objects.cube]
mass = { uniform = [0.05, 0.15] }
"""


@pytest.fixture
def evaluation(tmp_path):
    (tmp_path / "small.py").write_text(TREES)
    (tmp_path / "cube.toml").write_text(SCENE)
    for name, cube in (("fixture", FIXTURE), ("fixed", FIXED)):
        (tmp_path / f"{name}.toml").write_text(SCENE.partition("[randomization")[0] + cube)

    def make(name="light", **more):
        options = {"scene": str(tmp_path / "cube.toml"), "seed": 0, **more.pop("options", {})}
        return Evaluation(f"{tmp_path}/small.py:{name}", options, **more)

    return make
