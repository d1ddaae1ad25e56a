"""Parameters of a two-finger gripper in a robot's description."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pinocchio as pin

from bt_manip.robots import GripperDescription
from bt_manip.toml_tables import TomlTable

KIND = "two_finger"


@dataclass(frozen=True)
class PadParameters:
    """Contact parameters of the fingers' surfaces, which replace the model's.

    They also replace those of the touched object. Only the friction of a contact is the object's.

    Attributes:
        solref: MuJoCo's contact stiffness and damping (``solref``); None keeps the model's.
        solimp: MuJoCo's contact impedance (``solimp``); None keeps the model's.
    """

    solref: tuple[float, ...] | None = None
    solimp: tuple[float, ...] | None = None


@dataclass(frozen=True)
class TwoFingerParameters:
    """Parameters of a two-finger gripper; the attributes are those of `two_finger_gripper`."""

    joints: tuple[str, ...]
    fingers: tuple[str, ...]
    open_width: float | None
    max_speed: float
    min_width: float
    motor: str | None
    pads: PadParameters | None
    armature: float | None
    frictionloss: float | None


def two_finger_gripper(
    *,
    joints: Sequence[str],
    fingers: Sequence[str],
    max_speed: float,
    max_force: float,
    open_width: float | None = None,
    min_width: float | None = None,
    motor: str | None = None,
    pads: Mapping[str, Sequence[float]] | None = None,
    armature: float | None = None,
    frictionloss: float | None = None,
    model: str | None = None,
    mount: str | None = None,
    T_mg: pin.SE3 | None = None,
) -> GripperDescription:
    """Describe a two-finger gripper; ``[gripper]`` in a TOML file has the same keys.

    Each finger follows a joint: slides of either sign and any offset, hinges, and linkages. The
    second finger may be fixed. Openings, forces and directions are measured on the model, at the
    tool frame, whose z axis is the approach direction.

    Args:
        joints: Names of the joints that the fingers follow: one for each, or one for both.
        fingers: Names of the two finger bodies, in the order of the joints; of a moving and a fixed
            jaw, the moving one is the first.
        max_speed: Maximum speed of one finger [m/s].
        max_force: Maximum normal force of each finger [N].
        open_width: Maximum opening [m]; default: that of the model, which is the limit.
        min_width: Minimum opening [m]; default: that of the model.
        motor: Name of the joint or tendon moved by a motor for both fingers; default: what the
            model's actuator moves if the joints are coupled, or one motor for each joint.
        pads: Contact ``solref`` and ``solimp`` of the fingers' surfaces; None keeps the model's.
            The friction of a contact is the object's.
        armature: Armature of every joint of the mechanism [kg m2]; None keeps the model's.
        frictionloss: Dry friction of every joint of the mechanism [N m]; None keeps the model's.
        model: Path of its MJCF file; None if it is part of the arm's.
        mount: Name of the arm's site or body to which a separate model is attached.
        T_mg: Pose of that model in the mount; default: identity.
    """
    given: dict[str, Any] = {
        "joints": list(joints),
        "fingers": list(fingers),
        "max_speed": max_speed,
        "open_width": open_width,
        "min_width": min_width,
        "motor": motor,
        "pads": None if pads is None else {key: list(value) for key, value in pads.items()},
        "armature": armature,
        "frictionloss": frictionloss,
    }
    return GripperDescription(
        max_force=max_force,
        kind=KIND,
        parameters={key: value for key, value in given.items() if value is not None},
        model=model,
        mount=mount,
        T_mg=pin.SE3.Identity() if T_mg is None else T_mg,
    )


def read_parameters(table: TomlTable) -> TwoFingerParameters:
    """Read the parameters from a description.

    Raises:
        RobotError: If a key is missing, wrong or unknown; the message names it.
    """
    joints, fingers = table.texts("joints"), table.texts("fingers")
    if len(fingers) != 2:
        table.reject("fingers", f"names two bodies, got {len(fingers)}")
    if len(joints) not in (1, 2):
        table.reject("joints", f"names one joint or two, one a finger, got {len(joints)}")
    for key, names in (("joints", joints), ("fingers", fingers)):
        if len(set(names)) < len(names):
            hint = "; name it once if it moves both" if key == "joints" else ""
            table.reject(key, f"names '{names[0]}' twice{hint}")
    parameters = TwoFingerParameters(
        joints=joints,
        fingers=fingers,
        open_width=table.number("open_width", above=0.0),
        max_speed=table.needed_number("max_speed", above=0.0),
        min_width=table.number("min_width", 0.0, at_least=0.0) or 0.0,
        motor=table.text("motor"),
        pads=_pads(table.table("pads")),
        armature=table.number("armature", at_least=0.0),
        frictionloss=table.number("frictionloss", at_least=0.0),
    )
    if parameters.open_width is not None and parameters.min_width >= parameters.open_width:
        table.reject("min_width", f"is less than open_width, {parameters.open_width:g} m")
    table.finish()
    return parameters


def _pads(table: TomlTable | None) -> PadParameters | None:
    if table is None:
        return None
    given: dict[str, tuple[float, ...] | None] = {}
    for key, most in (("solref", 2), ("solimp", 5)):
        given[key] = table.numbers(key)
        if given[key] is not None and not 1 <= len(given[key] or ()) <= most:
            table.reject(key, f"is a list of 1 to {most} numbers")
    table.finish()
    return PadParameters(**{key: value for key, value in given.items() if value is not None})
