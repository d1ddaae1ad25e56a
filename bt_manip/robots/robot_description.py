"""What bt-manip must know of a robot that its model file does not say."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import pinocchio as pin

from .configurations import Configuration
from .errors import RobotError
from .gripper import GripperDescription


@dataclass(frozen=True)
class ToolLimits:
    """Bounds of the tool's motion along and about a line; the defaults are the Panda's.

    Attributes:
        velocity: Linear [m/s].
        acceleration: Linear [m/s2].
        jerk: Linear [m/s3].
        angular_velocity: [rad/s].
        angular_acceleration: [rad/s2].
        angular_jerk: [rad/s3].
    """

    velocity: float = 1.7
    acceleration: float = 13.0
    jerk: float = 6500.0
    angular_velocity: float = 2.5
    angular_acceleration: float = 25.0
    angular_jerk: float = 12500.0


@dataclass(frozen=True)
class RobotDescription:
    """An arm with a tool: data only, so that another arm is a few lines.

    Position limits, inertias, friction and (unless given here) effort limits are read from the
    model; MJCF has no place for the others.

    Attributes:
        name: What the robot is called in the cell and on the command line.
        model: Where its MJCF file is: a path, or ``menagerie:NAME/ENTRY``.
        arm_joints: Names of its arm's joints, from the base to the tool.
        tool_frame: Name of the site or body that poses are asked for.
        home: Configuration of the arm at the start [rad].
        velocity: Limit of each arm joint [rad/s].
        acceleration: Limit of each arm joint [rad/s2].
        jerk: Limit of each arm joint [rad/s3].
        gripper: The gripper, where there is one.
        effort: Limit of each arm joint [N m]; None takes them from the model.
        tool_limits: Bounds of the tool's motion along a straight line.
        T_ft: Pose of the tool in the tool frame.
        T_rb: Pose of the model's base where the robot is put: where it stands in a scene.
        pedestal: Size of a block that carries the base, in x, y and z [m]; it stands under it, on
            the plane that the robot is put on. None: there is none.
        configurations: Named configurations, besides ``home``.
    """

    name: str
    model: str
    arm_joints: tuple[str, ...]
    tool_frame: str
    home: tuple[float, ...]
    velocity: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...]
    gripper: GripperDescription | None = None
    effort: tuple[float, ...] | None = None
    tool_limits: ToolLimits = ToolLimits()
    T_ft: pin.SE3 = field(default_factory=pin.SE3.Identity)
    T_rb: pin.SE3 = field(default_factory=pin.SE3.Identity)
    pedestal: tuple[float, ...] | None = None
    configurations: Mapping[str, Configuration] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that there is one number a joint, and that what has a size has one."""
        n = len(self.arm_joints)
        if n == 0:
            raise RobotError(f"robot '{self.name}': a robot has at least one arm joint")
        for what in ("home", "velocity", "acceleration", "jerk", "effort"):
            values = getattr(self, what)
            if values is not None and len(values) != n:
                raise RobotError(
                    f"robot '{self.name}': one {what} for each of its {n} arm joints, "
                    f"got {len(values)}"
                )
        if self.pedestal is not None and (len(self.pedestal) != 3 or min(self.pedestal) <= 0.0):
            raise RobotError(
                f"robot '{self.name}': a pedestal has three positive sizes, got {self.pedestal}"
            )
