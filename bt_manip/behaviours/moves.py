"""Behaviours that move the tool or the joints of the arm."""

import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.bt import DOUBLE_LIST, Input, Traits
from bt_manip.exceptions import PortError
from bt_manip.kinematics import PoseTarget, PositionTarget, Target
from bt_manip.planning import ArcTo, LineTo, Planner, translate_along_tool_z
from bt_manip.registry import Registry

from .arm_behaviour import MotionBehaviour, blend_radius_input, speed_input
from .poses import pose_input, poses_input


class Move(MotionBehaviour):
    """A motion with a speed and a tolerance."""

    traits = Traits(commands={"arm"}, leaves={"at_object": None})

    blend_radius = blend_radius_input()
    speed = speed_input()
    tolerance = Input(
        float,
        default=MotionBehaviour.ARRIVED,
        doc="Largest error of a joint on arrival [rad].",
        above=0.0,
    )

    @property
    def largest_error(self) -> float:
        """Largest joint error on arrival [rad]."""
        return float(self.tolerance)


class PoseMove(Move):
    """A motion to a pose of the tool, with rotations that may be free."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")
    free_axis = Input(
        str,
        default="",
        doc="Axis of the tool, x, y or z, about which the rotation is free; 'all': any rotation.",
    )
    cone = Input(float, default=0.0, doc="Largest angle by which the free axis may tilt [rad].")

    @property
    def target(self) -> pin.SE3 | Target:
        """The pose, or a target with free rotations."""
        tool = self.arm.ik.tool
        if self.free_axis == "all":
            return PositionTarget(tool, self.pose.translation)
        if self.free_axis or self.cone:
            return PoseTarget(tool, self.pose, free_axis=self.free_axis or None, cone=self.cone)
        return self.pose


class PlannedMove(Move):
    """A motion around obstacles."""

    planner = Input(
        str, default="", doc="Name of a registered planner; by default that of the run."
    )

    def setup(self, **infrastructure: Any) -> None:
        """Store the planners and their random generator, too."""
        super().setup(**infrastructure)
        self._rng: np.random.Generator = infrastructure["rng"]
        self._planners: Registry[Callable[..., Planner]] = infrastructure["planners"]

    def planning(self) -> dict[str, Any]:
        """Return the planner and the random generator.

        Raises:
            UnknownPartError: If the planner is not registered.
        """
        name = self.planner
        planner: Planner | None = self._planners.create(name) if name else None
        return {"planner": planner, "rng": self._rng}


class Approach(Move):
    """Move the tool forwards along its z axis."""

    distance = Input(float, default=0.1, doc="Distance [m].")

    def start(self) -> None:
        """Move along the z axis of the tool."""
        self.advance_by(self.distance)

    def advance_by(self, distance: float) -> None:
        """Move the tool along its z axis by a distance [m].

        Raises:
            MotionError: If the line cannot be followed or is blocked.
        """
        T_wt = self.arm.model.pose(self.arm.target)
        self.arm.move_linear(translate_along_tool_z(T_wt, distance), speed=self.speed)


class Retreat(Approach):
    """Move the tool backwards along its z axis."""

    def start(self) -> None:
        """Move against the z axis of the tool."""
        self.advance_by(-self.distance)


class MoveToPose(PoseMove, PlannedMove):
    """Move the tool to a pose in the world, around obstacles."""

    linear = Input(bool, default=False, doc="Whether the tool moves along a straight line.")

    def start(self) -> None:
        """Plan a collision-free motion, or a straight line of the tool."""
        if self.linear:
            self.arm.move_linear(self.target, speed=self.speed)
        else:
            self.arm.move_to_pose(self.target, speed=self.speed, **self.planning())


class MoveLinear(PoseMove):
    """Move the tool to a pose along a straight line, with uniform rotation."""

    def start(self) -> None:
        """Move along the line, or fail with the fraction that can be followed."""
        self.arm.move_linear(self.target, speed=self.speed)


class MoveArc(Move):
    """Move the tool to a pose along a circular arc, with uniform rotation."""

    via = Input(list[float], doc="A point of the arc in the world: x;y;z [m].")
    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")

    def start(self) -> None:
        """Move along the arc, or fail with the fraction that can be followed."""
        self.arm.move_path([ArcTo(self.via, self.pose)], speed=self.speed)


class MoveThrough(Move):
    """Move the tool through poses on straight lines, with blended corners."""

    poses = poses_input(
        "Poses of the tool in the world, each x;y;z;qw;qx;qy;qz [m], separated by |."
    )
    blend = Input(
        float,
        default=0.02,
        doc="Blend distance from each corner [m]; 0: the tool stops at corners.",
    )

    def start(self) -> None:
        """Move along the lines, or fail with the fraction that can be followed."""
        steps = [LineTo(pose) for pose in self.poses]
        self.arm.move_path(steps, speed=self.speed, blend=self.blend)


def _parse_joints(text: str) -> list[float] | str:
    """Parse joint positions, or the name of a configuration."""
    assert DOUBLE_LIST.parse is not None
    try:
        return DOUBLE_LIST.parse(text)
    except ValueError:
        if ";" in text or not text.strip():
            raise
        return text


def _format_joints(value: list[float] | str) -> str:
    assert DOUBLE_LIST.format is not None
    return value if isinstance(value, str) else DOUBLE_LIST.format(value)


JOINTS = replace(DOUBLE_LIST, parse=_parse_joints, format=_format_joints)
"""Joint positions, or the name of a configuration."""


class MoveToConfiguration(PlannedMove):
    """Move the arm's joints to given positions, around obstacles."""

    configuration = Input(
        JOINTS, doc="Joint positions, separated by ';' [rad], or the name of a configuration."
    )

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell and the robots, and check the name of a configuration."""
        super().setup(**infrastructure)
        with contextlib.suppress(PortError):  # its entry is written later
            if isinstance(name := self.configuration, str) and self.robot_name:
                self.arm.robot.configuration(name)

    def start(self) -> None:
        """Plan a collision-free motion; a joint-space segment where that is free."""
        wanted = self.configuration
        if isinstance(wanted, str):
            wanted = self.arm.robot.configuration(wanted)
        self.arm.move_to_configuration(wanted, speed=self.speed, **self.planning())


class MoveHome(PlannedMove):
    """Move the arm to the home configuration of its description, around obstacles."""

    def start(self) -> None:
        """Plan a collision-free motion; a joint-space segment where that is free."""
        home = self.arm.robot.description.home
        self.arm.move_to_configuration(home, speed=self.speed, **self.planning())


class BackOff(Move):
    """Move back along the path of the last motion, e.g. after a collision."""

    distance = Input(float, default=0.1, doc="Travel of the tool [m]; less on a shorter path.")

    def start(self) -> None:
        """Move back."""
        self.arm.back_off(self.distance, self.speed)
