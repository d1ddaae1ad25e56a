from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from dm_control import composer, mjcf

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld
from bt_manip.grippers import TwoFingerGripper
from bt_manip.kinematics import InverseKinematics
from bt_manip.robots import (
    Robot,
    RobotDescription,
    RobotModel,
    compile_alone,
    panda,
    read_description,
)

LEAST = """
model = "arm.xml"
arm_joints = ["a", "b"]
home = [0.0, 1.0]
velocity = 2
acceleration = 3.0
jerk = [4, 5.5]
[tool]
frame = "tip"
"""
GRIPPER = """
[gripper]
joints = ["left", "right"]
fingers = ["one", "two"]
open_width = 0.08
max_speed = 0.1
max_force = 20
"""


def described(model: Path) -> RobotDescription:
    """Return the description of an arm of two joints."""
    return RobotDescription(
        name=model.stem,
        model=str(model),
        arm_joints=("shoulder", "elbow"),
        tool_frame="tip",
        home=(0.1, 0.2),
        velocity=(1.0, 1.0),
        acceleration=(5.0, 5.0),
        jerk=(100.0, 100.0),
    )


def compiled(description: RobotDescription, **options: Any) -> Robot:
    """Return a robot, compiled alone."""
    robot = Robot(description, **options)
    compile_alone(robot)
    return robot


@pytest.fixture(scope="session")
def compiled_robot() -> Robot:
    return compiled(panda(), gripper=TwoFingerGripper)


@pytest.fixture(scope="session")
def prepared_ik(compiled_robot: Robot) -> InverseKinematics:
    return InverseKinematics(compiled_robot.make_model())


@pytest.fixture
def robot(compiled_robot: Robot) -> Robot:
    """Give the robot at home: tests here only ever set its configuration."""
    compiled_robot.set_configuration(np.array(compiled_robot.description.home))
    return compiled_robot


@pytest.fixture
def model(robot: Robot) -> RobotModel:
    return robot.make_model()


@pytest.fixture
def ik(prepared_ik: InverseKinematics) -> InverseKinematics:
    return prepared_ik


@pytest.fixture
def arm(robot: Robot, ik: InverseKinematics) -> Arm:
    return Arm(robot, ik=ik)


@pytest.fixture(scope="session")
def five_joints() -> Robot:
    """Give an arm of five joints, whose model has rounded numbers, compiled alone."""
    description = read_description(Path(__file__).parent / "robots/models/five_joints.toml")
    return compiled(description, gripper=TwoFingerGripper)


@pytest.fixture(scope="session")
def rail_robot() -> Robot:
    """Give an arm of six joints on a rail, compiled alone."""
    description = read_description(Path(__file__).parent / "robots/models/rail.toml")
    return compiled(description, gripper=TwoFingerGripper)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


class Box(composer.Entity):
    """A box that stands fixed; its origin is its centre."""

    def _build(self, size: Sequence[float], name: str = "box") -> None:
        self._root = mjcf.RootElement(model=name)
        self._root.worldbody.add("geom", name="box", type="box", size=[0.5 * x for x in size])

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        return self._root


class Walled(NamedTuple):
    """The Panda at a table with a wall between two places, its base in the origin of the world."""

    cell: Cell
    robot: Robot
    ik: InverseKinematics
    world: CollisionWorld
    left: pin.SE3
    right: pin.SE3


@pytest.fixture(scope="session")
def walled() -> Walled:
    cell, robot = Cell(Floating()), Robot(panda(), gripper=TwoFingerGripper)
    with cell.editing():
        cell.add(robot, free=False)
        cell.add(Box((0.7, 1.2, 0.1)), spatial.pose((0.55, 0.0, -0.05)), name="top")
        cell.add(Box((0.5, 0.04, 0.4)), spatial.pose((0.5, 0.0, 0.2)), name="wall")
    model = robot.make_model()
    left, right = (spatial.pointing_down((0.5, y, 0.12), 0.0) for y in (0.25, -0.25))
    return Walled(cell, robot, InverseKinematics(model), CollisionWorld(robot, model), left, right)


class Floating(composer.Arena):
    """An arena with nothing in it, not even a floor."""


UR5E_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
MENAGERIE_ARMS = {
    "ur5e": ("universal_robots_ur5e/ur5e.xml", "{}_joint", "attachment_site"),
    "iiwa14": ("kuka_iiwa_14/iiwa14.xml", "joint{}", "attachment_site"),
    "fr3": ("franka_fr3/fr3.xml", "fr3_joint{}", "attachment_site"),
    "xarm7": ("ufactory_xarm7/xarm7.xml", "joint{}", "link_tcp"),
}


def menagerie_robot(menagerie: Path, name: str, bend: float = 0.0, **limits: float) -> Robot:
    """Return another arm, compiled alone and described in a few lines.

    Args:
        menagerie: Folder of the models.
        name: Key of `MENAGERIE_ARMS`.
        bend: Position of most joints in the home configuration [rad].
        limits: Limits of all joints by field of the description.
    """
    file, joints, site = MENAGERIE_ARMS[name]
    names = tuple(joints.format(i) for i in (UR5E_JOINTS if name == "ur5e" else range(1, 8)))
    n = len(names)
    limits = {"velocity": 2.0, "acceleration": 5.0, "jerk": 1000.0, "effort": 50.0} | limits
    description = RobotDescription(
        name="other",
        model=str(menagerie / file),
        arm_joints=names,
        tool_frame=site,
        home=(bend, bend, bend, -1.5, bend, 1.5, bend) if name == "fr3" else (bend,) * n,
        **{field: (value,) * n for field, value in limits.items()},
    )
    return compiled(description)
