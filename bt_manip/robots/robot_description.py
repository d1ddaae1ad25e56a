"""Description of a robot: data that its model file does not contain."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import pinocchio as pin

from .configurations import Configuration
from .errors import RobotError
from .gripper import GripperDescription


@dataclass(frozen=True)
class ToolLimits:
    """Limits of the tool's motion along and about a line; the defaults are the Panda's.

    Attributes:
        velocity: Maximum linear velocity [m/s].
        acceleration: Maximum linear acceleration [m/s2].
        jerk: Maximum linear jerk [m/s3].
        angular_velocity: Maximum angular velocity [rad/s].
        angular_acceleration: Maximum angular acceleration [rad/s2].
        angular_jerk: Maximum angular jerk [rad/s3].
    """

    velocity: float = 1.7
    acceleration: float = 13.0
    jerk: float = 6500.0
    angular_velocity: float = 2.5
    angular_acceleration: float = 25.0
    angular_jerk: float = 12500.0


@dataclass(frozen=True)
class Tolerance:
    """Largest errors of the tool pose that inverse kinematics accepts.

    It aims at 1e-6 m and rad; the tolerance is for poses that the joints reach only nearly, since
    the numbers of a model are rounded.

    Attributes:
        position: Largest distance [m].
        rotation: Largest angle [rad].
    """

    position: float = 1e-5
    rotation: float = 1e-4


@dataclass(frozen=True)
class RobotDescription:
    """Description of an arm with a tool: data only.

    Position limits, inertias, friction and (unless given here) effort limits are read from the
    model; MJCF has no attributes for the other limits.

    Attributes:
        name: Name of the robot in the cell and on the command line.
        model: Its MJCF file: a path, or ``menagerie:NAME/ENTRY``.
        arm_joints: Names of its arm's joints, from the base to the tool. Joints that are not
            beyond the first one, such as those of a second arm, are locked.
        tool_frame: Name of the site or body that the tool pose is relative to.
        home: Configuration of the arm at the start [rad].
        velocity: Velocity limit of each arm joint [rad/s].
        acceleration: Acceleration limit of each arm joint [rad/s2].
        jerk: Jerk limit of each arm joint [rad/s3].
        gripper: The gripper; None if there is none.
        effort: Effort limit of each arm joint [N m]; None reads them from the model.
        armature: Rotor inertia of each arm joint, times the gear ratio squared [kg m2], in place of
            the model's; None keeps that.
        tool_limits: Limits of the tool's motion along a straight line.
        tolerance: Largest errors of the tool pose in inverse kinematics.
        T_ft: Pose of the tool in the tool frame.
        T_rb: Pose of the model's base relative to the robot's placement in the scene.
        pedestal: Size of a block under the base, in x, y and z [m]; it stands on the plane on which
            the robot is placed. None for no pedestal.
        exclude: Pairs of bodies of the robot whose contacts are ignored, in the physics and in
            planning: bodies that overlap in every configuration. Names are those of the model
            files; the body of the pedestal is ``pedestal``.
        configurations: Named configurations, besides ``home``.
        source: The file that it was read from, for messages.
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
    armature: tuple[float, ...] | None = None
    tool_limits: ToolLimits = ToolLimits()
    tolerance: Tolerance = Tolerance()
    T_ft: pin.SE3 = field(default_factory=pin.SE3.Identity)
    T_rb: pin.SE3 = field(default_factory=pin.SE3.Identity)
    pedestal: tuple[float, ...] | None = None
    exclude: tuple[tuple[str, str], ...] = ()
    configurations: Mapping[str, Configuration] = field(default_factory=dict)
    source: str = field(default="", compare=False)

    @property
    def where(self) -> str:
        """The robot, with the file of its description if there is one, to begin a message."""
        return f"{self.source and f'{self.source}: '}robot '{self.name}'"

    def __str__(self) -> str:
        """Return the file that it was read from, or its name."""
        return self.source or self.name

    def __post_init__(self) -> None:
        """Check numbers of values, the pedestal's sizes and the excluded pairs."""
        n = len(self.arm_joints)
        if n == 0 or len(set(self.arm_joints)) < n:
            raise RobotError(
                f"{self.where}: the arm has at least one joint, and each is named once, got "
                f"{', '.join(self.arm_joints) or 'none'}"
            )
        for what in ("home", "velocity", "acceleration", "jerk", "effort", "armature"):
            values = getattr(self, what)
            if values is not None and len(values) != n:
                raise RobotError(
                    f"{self.where}: one {what} for each of its {n} arm joints, got {len(values)}"
                )
        if self.pedestal is not None and (len(self.pedestal) != 3 or min(self.pedestal) <= 0.0):
            raise RobotError(
                f"{self.where}: a pedestal has three positive sizes, got {self.pedestal}"
            )
        for pair in self.exclude:
            if len(pair) != 2 or pair[0] == pair[1]:
                raise RobotError(f"{self.where}: exclude has pairs of two bodies, got {pair}")
