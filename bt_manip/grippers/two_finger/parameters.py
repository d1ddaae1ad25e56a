"""Parameters of a two-finger gripper in a robot's description."""

from dataclasses import dataclass
from typing import Annotated, Any

import pinocchio as pin

from bt_manip.robots import GripperDescription
from bt_manip.toml import Key, TomlTable, documented, plain, read_part

from .finger_travel import FingerTravel, TravelTable

KIND = "two_finger"


@documented
@dataclass(frozen=True)
class PadParameters:
    """Contact parameters of the fingers' surfaces, in place of the model's.

    In contacts they prevail over the touched object's, except for the friction.
    """

    solref: Annotated[
        tuple[float, ...] | None,
        Key("MuJoCo's contact stiffness and damping; by default the model's", size=(1, 2)),
    ] = None
    solimp: Annotated[
        tuple[float, ...] | None,
        Key("MuJoCo's contact impedance; by default the model's", size=(1, 5)),
    ] = None


@documented
@dataclass(frozen=True)
class TwoFingerParameters:
    """Parameters of a two-finger gripper, which are keys of ``[gripper]``."""

    joints: Annotated[
        tuple[str, ...],
        Key(
            "Names of the joints that the fingers follow: one for each, or one for both",
            size=(1, 2),
        ),
    ]
    fingers: Annotated[
        tuple[str, ...],
        Key(
            "Names of the two finger bodies, in the order of the joints; a moving jaw comes "
            "before a fixed one",
            size=2,
        ),
    ]
    max_speed: Annotated[float, Key("Maximum speed of one finger", "m/s", above=0.0)]
    open_width: Annotated[
        float | None,
        Key("Maximum opening; by default, and at most, that of the model", "m", above=0.0),
    ] = None
    min_width: Annotated[
        float, Key("Minimum opening; by default that of the model", "m", at_least=0.0)
    ] = 0.0
    motor: Annotated[
        str | None,
        Key(
            "Name of the joint or tendon moved by one motor for both fingers; by default that of "
            "the model's actuator if the joints are coupled, otherwise each joint has a motor"
        ),
    ] = None
    travel: Annotated[
        FingerTravel | None,
        Key(
            "Travel of the fingers, measured on the model; required, and measured again after "
            "changes of the gripper's model or of the keys above",
            values=TravelTable(),
        ),
    ] = None
    pads: Annotated[PadParameters | None, Key("Contact parameters of the fingers' surfaces")] = None
    armature: Annotated[
        float | None,
        Key(
            "Armature of all joints of the mechanism; by default the model's",
            "kg m2",
            at_least=0.0,
        ),
    ] = None
    frictionloss: Annotated[
        float | None,
        Key(
            "Dry friction of all joints of the mechanism; by default the model's",
            "N m",
            at_least=0.0,
        ),
    ] = None


def two_finger_gripper(
    *,
    max_force: float,
    model: str | None = None,
    mount: str | None = None,
    T_mg: pin.SE3 | None = None,
    **parameters: Any,
) -> GripperDescription:
    """Describe a two-finger gripper; ``[gripper]`` in a TOML file has the same keys.

    Each finger follows a joint: a slide of either sign and any offset, a hinge, or a linkage. The
    second finger may be fixed. Openings, forces and directions are those of `travel` at the tool
    frame, whose z axis is the approach direction: the path of the TOML file to which ``bt-manip
    robot measure NAME`` writes what it measures on the model.

    Args:
        max_force: Maximum normal force of each finger [N].
        model: Path of its MJCF file; None if it is part of the arm's file.
        mount: Name of the arm's site or body to which a separate model is attached.
        T_mg: Pose of that model in the mount; default: identity.
        **parameters: The fields of `TwoFingerParameters`; None is the default.
    """
    return GripperDescription(
        max_force=max_force,
        kind=KIND,
        parameters={key: plain(value) for key, value in parameters.items() if value is not None},
        model=model,
        mount=mount,
        T_mg=pin.SE3.Identity() if T_mg is None else T_mg,
    )


def read_parameters(table: TomlTable) -> TwoFingerParameters:
    """Read the parameters from a description.

    Raises:
        RobotError: If a key is missing, wrong or unknown; the message names it.
    """
    parameters = read_part(TwoFingerParameters, table)
    assert parameters is not None  # otherwise the table raises an error
    if parameters.open_width is not None and parameters.min_width >= parameters.open_width:
        raise table.error("min_width", f"is less than open_width, {parameters.open_width:g} m")
    return parameters
