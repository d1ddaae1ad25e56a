"""Scenes: the robots and objects that a run begins with."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Region
from bt_manip.cell.randomization import Randomization
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Registry
from bt_manip.robots import Configuration, RobotDescription, read_description


@dataclass(frozen=True)
class Fixture:
    """An object of a scene.

    Attributes:
        model: Registered name of the object, or address of a model.
        name: Its name in the cell.
        T_wo: Its pose in the world; with ``on``, z is the height above the resting height.
        parameters: Keyword arguments that the object is made with.
        free: Whether it moves freely; None: as the object declares.
        on: Name of an earlier fixture whose surface it rests on.
        region: A free pose is sampled from it with the run's seed, in place of ``T_wo``.
        within_reach: Whether it is moved to where the first robot reaches it, and its sampled poses
            are those that are reached; or the name of the robot.
    """

    model: str
    name: str
    T_wo: pin.SE3
    parameters: Mapping[str, Any] = field(default_factory=dict)
    free: bool | None = False
    on: str = ""
    region: Region | None = None
    within_reach: bool | str = False


@dataclass(frozen=True)
class SceneRobot:
    """A robot of a scene, at home.

    Attributes:
        T_wb: Pose of its base in the world.
        name: Its name in the cell; empty: that of its description.
        description: Name of a registered robot, path of a TOML file that describes one, or a
            description; None: that of the run.
        controller: Name of a registered controller; None: that of the run.
        planner: Name of a registered planner; None: that of the run.
        for_reach: Reach of the arm that the position is for [m]: the first joint of an arm with
            another reach is nearer to the world's origin, or farther, in proportion, and above
            the position; None: the position is that of any arm. At home the tool keeps 0.15 m
            from the origin.
    """

    T_wb: pin.SE3
    name: str = ""
    description: str | RobotDescription | None = None
    controller: str | None = None
    planner: str | None = None
    for_reach: float | None = None


@dataclass(frozen=True)
class Scene:
    """The robots and objects that a run begins with.

    Attributes:
        robots: The robots, at least one.
        fixtures: The objects, in the order in which they are added.
        randomization: What varies from cycle to cycle.
        seed: Seed of runs that give none.
        about: A description in one sentence.
        configurations: Named configurations of its robots, besides those of their descriptions.
        source: The file that it was read from.
        name: Its name in reports.
    """

    robots: tuple[SceneRobot, ...]
    fixtures: tuple[Fixture, ...] = ()
    randomization: Randomization = field(default_factory=Randomization)
    seed: int | None = None
    about: str = ""
    source: str = ""
    configurations: Mapping[str, Configuration] = field(default_factory=dict)
    name: str = ""

    def __str__(self) -> str:
        """Return the file that it was read from, or its name."""
        return self.source or self.name or "built in Python"

    def __post_init__(self) -> None:
        """Check the robots' names.

        Raises:
            BtManipError: If there is no robot, or two have the same name.
        """
        if not self.robots:
            raise BtManipError("a scene needs at least one robot")
        names = [robot.name for robot in self.robots]
        for name in names:
            if len(names) > 1 and not name:
                raise BtManipError("where a scene has several robots, each needs a name")
            if names.count(name) > 1:
                raise BtManipError(f"two robots of the scene are called '{name}'")

    @property
    def T_wb(self) -> pin.SE3:
        """Pose of the first robot's base in the world."""
        return self.robots[0].T_wb


@cache
def table_and_basket() -> Scene:
    """Return the scene of the pick and place task: a robot on a table, and a basket beside it.

    Measures of gym-gz's Panda pick and place; the base stands on the table's surface, not 15 mm
    inside it. The basket is nearer where the robot cannot drop into it there.
    """
    surface = 1.015  # [m] above the floor
    quarter_turn = (0.5**0.5, 0.0, 0.0, 0.5**0.5)
    return Scene(
        robots=(SceneRobot(spatial.pose((-0.1, 0.0, surface))),),
        fixtures=(
            Fixture("table", "table", spatial.pose((0.0, 0.0, 0.0))),
            Fixture(
                "basket",
                "basket",
                spatial.pose((0.68, 0.0, surface), quarter_turn),
                within_reach=True,
            ),
        ),
        name="table_and_basket",
    )


@cache
def two_arms() -> Scene:
    """Return the scene of two robots that face each other on a table, each with a basket."""
    surface = 1.015  # [m] above the floor
    half_turn = (0.0, 0.0, 0.0, 1.0)
    return Scene(
        robots=(
            SceneRobot(spatial.pose((-0.55, 0.0, surface)), "left"),
            SceneRobot(spatial.pose((0.55, 0.0, surface), half_turn), "right"),
        ),
        fixtures=(
            Fixture("table", "table", spatial.pose((0.0, 0.0, 0.0))),
            Fixture("basket", "left_basket", spatial.pose((-0.3, 0.3, surface))),
            Fixture("basket", "right_basket", spatial.pose((0.3, -0.3, surface), half_turn)),
        ),
        name="two_arms",
    )


def find_robot(
    robot: str | RobotDescription, robots: Registry[RobotDescription]
) -> RobotDescription:
    """Return the description of a robot.

    Args:
        robot: A registered name, the path of a TOML file that describes one, or a description.
        robots: The registered descriptions.

    Raises:
        BtManipError: If there is no such robot, or its file is invalid.
    """
    if isinstance(robot, RobotDescription):
        return robot
    return read_description(robot) if str(robot).endswith(".toml") else robots.get(robot)
