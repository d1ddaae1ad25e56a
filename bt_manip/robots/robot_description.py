"""Description of a robot: data that its model file does not contain."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated

import pinocchio as pin

from bt_manip.toml import Key, check_fields, documented

from .configurations import Configuration, Configurations
from .errors import RobotError
from .gripper_description import GripperDescription, GripperTable
from .model_address import ModelAddress

Numbers = tuple[float, ...]
NEAR_LIMITS = "velocity_near_limits"  # table of the keys `near_...`


@documented
@dataclass(frozen=True)
class ToolLimits:
    """Limits of the tool's motion along and about a line; the defaults are the Panda's."""

    velocity: Annotated[float, Key("Maximum linear velocity", "m/s", above=0.0)] = 1.7
    acceleration: Annotated[float, Key("Maximum linear acceleration", "m/s2", above=0.0)] = 13.0
    jerk: Annotated[float, Key("Maximum linear jerk", "m/s3", above=0.0)] = 6500.0
    angular_velocity: Annotated[float, Key("Maximum angular velocity", "rad/s", above=0.0)] = 2.5
    angular_acceleration: Annotated[
        float, Key("Maximum angular acceleration", "rad/s2", above=0.0)
    ] = 25.0
    angular_jerk: Annotated[float, Key("Maximum angular jerk", "rad/s3", above=0.0)] = 12500.0


@documented
@dataclass(frozen=True)
class Tolerance:
    """Largest errors of the tool pose that inverse kinematics accepts.

    It aims at 1e-6 m and rad; the tolerance is for poses that the joints reach only nearly, since
    the numbers of a model are rounded. 1e-4 m and 5e-3 rad let an arm of five joints set down what
    it holds slightly tilted.
    """

    position: Annotated[float, Key("Largest distance", "m", above=0.0)] = 1e-5
    rotation: Annotated[float, Key("Largest angle", "rad", above=0.0)] = 1e-4


@documented
@dataclass(frozen=True)
class RobotDescription:
    """Description of an arm with a tool: data only, each field also a key of a TOML file.

    Position limits, inertias, friction and (unless given here) effort limits are read from the
    model; MJCF has no attributes for the other limits. The field `source`, not a key, is the file
    that it was read from.
    """

    name: Annotated[
        str,
        Key(
            "Name of the robot in the cell and on the command line; by default that of the file",
            needed=False,
        ),
    ]
    model: Annotated[str, Key("Its MJCF or URDF file", values=ModelAddress())]
    arm_joints: Annotated[
        tuple[str, ...],
        Key(
            "Names of its arm's joints, from the base to the tool; joints that are not beyond the "
            "first one, such as those of a second arm, are locked"
        ),
    ]
    tool_frame: Annotated[
        str,
        Key("Site or body that the tool pose is relative to", table="tool", name="frame"),
    ]
    home: Annotated[Numbers, Key("Configuration of the arm at the start", "rad", size="arm_joints")]
    velocity: Annotated[
        Numbers, Key("Velocity limits of the joints", "rad/s", above=0.0, size="arm_joints")
    ]
    acceleration: Annotated[
        Numbers, Key("Acceleration limits of the joints", "rad/s2", above=0.0, size="arm_joints")
    ]
    jerk: Annotated[
        Numbers, Key("Jerk limits of the joints", "rad/s3", above=0.0, size="arm_joints")
    ]
    limit_margin: Annotated[
        float,
        Key(
            "Fraction of the limits of velocity, acceleration and jerk that motions leave unused, "
            "for a controller that refuses commands at its limits",
            at_least=0.0,
        ),
    ] = 0.0
    near_offset: Annotated[
        Numbers | None,
        Key(
            "Near its position limits, the velocity of a joint is limited to -`offset` + "
            "sqrt(2 `deceleration` d), with its distance d from `lower` or `upper` in the "
            "direction of motion; motions end where 2.5 % of the velocity limit are left",
            "rad/s",
            at_least=0.0,
            size="arm_joints",
            table=NEAR_LIMITS,
            name="offset",
        ),
    ] = None
    near_deceleration: Annotated[
        Numbers | None,
        Key(
            "Deceleration of this formula; a great one for joints without such a limit",
            "rad/s2",
            above=0.0,
            size="arm_joints",
            table=NEAR_LIMITS,
            name="deceleration",
        ),
    ] = None
    near_lower: Annotated[
        Numbers | None,
        Key(
            "Lower ends of the ranges of this formula; by default those of the model",
            "rad",
            size="arm_joints",
            table=NEAR_LIMITS,
            name="lower",
        ),
    ] = None
    near_upper: Annotated[
        Numbers | None,
        Key(
            "Upper ends of the ranges of this formula; by default those of the model",
            "rad",
            size="arm_joints",
            table=NEAR_LIMITS,
            name="upper",
        ),
    ] = None
    gripper: Annotated[
        GripperDescription | None,
        Key("The gripper; without it, there is none", values=GripperTable()),
    ] = None
    effort: Annotated[
        Numbers | None,
        Key(
            "Effort limits of the joints; by default those of the model",
            "N m",
            above=0.0,
            size="arm_joints",
        ),
    ] = None
    armature: Annotated[
        Numbers | None,
        Key(
            "Rotor inertia of each joint's motor times the gear ratio squared, in place of the "
            "model's; controllers need some to be stiff",
            "kg m2",
            at_least=0.0,
            size="arm_joints",
        ),
    ] = None
    tool_limits: Annotated[ToolLimits, Key("Limits of the tool along lines and arcs only")] = (
        ToolLimits()
    )
    tool_speed: Annotated[
        float | None,
        Key(
            "Maximum speed of the tool's origin in every motion; by default 0.25 on a real robot, "
            "unlimited in simulation",
            "m/s",
            above=0.0,
        ),
    ] = None
    tolerance: Annotated[Tolerance, Key("Largest errors in inverse kinematics")] = Tolerance()
    T_ft: Annotated[pin.SE3, Key("Pose of the tool in the tool frame", "m, rad", table="tool")] = (
        field(default_factory=pin.SE3.Identity)
    )
    T_rb: Annotated[
        pin.SE3,
        Key(
            "Pose of the model's base relative to where a scene places the robot",
            "m, rad",
            table="base",
        ),
    ] = field(default_factory=pin.SE3.Identity)
    pedestal: Annotated[
        Numbers | None,
        Key(
            "Size of a block under the base, in x, y and z, on the plane on which the robot is "
            "placed",
            "m",
            above=0.0,
            size=3,
            table="base",
        ),
    ] = None
    exclude: Annotated[
        tuple[tuple[str, str], ...],
        Key(
            "Pairs of bodies of the robot whose contacts are ignored, in the physics and in "
            "planning: bodies that overlap by design. Names are those of the model files; the "
            "block under the base is `pedestal`"
        ),
    ] = ()
    convex_parts: Annotated[
        tuple[str, ...],
        Key(
            "Bodies whose meshes collide as several convex parts in place of one hull, such as "
            "concave jaws; `pip install 'bt-manip[convex]'`"
        ),
    ] = ()
    configurations: Annotated[
        Mapping[str, Configuration],
        Key(
            "Named configurations for `MoveToConfiguration`, besides `home`",
            "rad",
            values=Configurations(),
        ),
    ] = field(default_factory=dict)
    source: str = field(default="", compare=False)

    @property
    def where(self) -> str:
        """The robot, with the file of its description if there is one, to begin a message."""
        return f"{self.source and f'{self.source}: '}robot '{self.name}'"

    def __str__(self) -> str:
        """Return the file that it was read from, or its name."""
        return self.source or self.name

    def __post_init__(self) -> None:
        """Check the values as if they came from a file."""
        check_fields(self, self.where, RobotError)
        if not self.limit_margin < 1.0:
            raise RobotError(f"{self.where}: 'limit_margin' is below 1, got {self.limit_margin:g}")
        near = (self.near_offset, self.near_deceleration, self.near_lower, self.near_upper)
        if near != (None,) * 4 and None in near[:2]:
            raise RobotError(f"{self.where}: [{NEAR_LIMITS}] needs 'offset' and 'deceleration'")
