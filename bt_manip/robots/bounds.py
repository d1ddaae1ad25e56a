"""Bounds of an arm's motions: ranges of its joints, and a box for its tool."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np

from bt_manip.exceptions import did_you_mean
from bt_manip.toml import Key, KeyField, OtherKeys, TomlTable, documented

from .errors import RobotError
from .motion_limits import MotionLimits
from .robot_description import RobotDescription

Range = tuple[float, float]


class JointRanges(OtherKeys):
    """A range for each joint that a table names."""

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> dict[str, Any]:
        """Return the ranges by joint."""
        return {joint: table.numbers(joint, 2) or (0.0, 0.0) for joint in table.rest()}


@documented
@dataclass(frozen=True)
class ArmBounds:
    """Bounds within an arm's position limits and reach, each a lowest and a highest value."""

    x: Annotated[Range | None, Key("Bounds of the tool in the world", "m", size=2)] = None
    y: Annotated[Range | None, Key("Bounds of the tool in the world", "m", size=2)] = None
    z: Annotated[Range | None, Key("Bounds of the tool in the world", "m", size=2)] = None
    joints: Annotated[
        Mapping[str, Range],
        Key("Bounds of the joint of this name", "rad", values=JointRanges("2 numbers", "JOINT")),
    ] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the bounds.

        Raises:
            RobotError: If the lower one is not below the upper one.
        """
        for name, bounds in {"x": self.x, "y": self.y, "z": self.z, **self.joints}.items():
            if bounds is not None and not bounds[0] < bounds[1]:
                raise RobotError(f"the bounds of '{name}' go from low to high, got {list(bounds)}")

    def narrowed(self, limits: MotionLimits, description: RobotDescription) -> MotionLimits:
        """Return limits of motions with the position limits and the tool inside these bounds.

        Args:
            limits: The arm's limits.
            description: Its description, with the names of the joints.

        Raises:
            RobotError: If there is no joint of a name, or no range is left to it.
        """
        lower, upper = limits.lower.copy(), limits.upper.copy()
        joints, where = description.arm_joints, description.where
        for name, (low, high) in self.joints.items():
            if name not in joints:
                near = did_you_mean(name, joints)
                raise RobotError(f"{where}: bounds: there is no joint '{name}'{near}")
            i = joints.index(name)
            if not max(low, lower[i]) < min(high, upper[i]):
                raise RobotError(
                    f"{where}: bounds: joint '{name}' has no range left: its position limits are "
                    f"{lower[i]:.4f} to {upper[i]:.4f}"
                )
            lower[i], upper[i] = max(low, lower[i]), min(high, upper[i])
        box = None
        if (self.x, self.y, self.z) != (None, None, None):
            box = np.array([axis or (-np.inf, np.inf) for axis in (self.x, self.y, self.z)]).T
        return replace(limits, lower=lower, upper=upper, box=box)
