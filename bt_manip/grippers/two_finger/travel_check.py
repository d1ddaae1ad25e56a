"""Check that a measured travel fits the gripper's model and description."""

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco

from bt_manip import spatial
from bt_manip.robots import Robot, RobotError, site_pose

from .finger_travel import FingerTravel
from .parameters import TwoFingerParameters

_KEYS = ("joints", "fingers", "motor", "armature", "frictionloss")
_IGNORED = (
    "class", "childclass", "group", "material", "rgba", "user", "assetdir", "meshdir", "texturedir",
)  # fmt: skip
_JOINTS = ("joint", "freejoint")
_DIGITS = 9  # significant digits of the model's numbers
_DECIMALS = 6  # [m] and of quaternions, of the tool frame, which is computed
_LENGTH = 16  # hexadecimal digits of a digest

Defaults = dict[str, dict[str, str]]
"""Attributes of a default class by tag."""


def checked_travel(robot: Robot, parameters: TwoFingerParameters) -> FingerTravel:
    """Return the measured travel of a described gripper.

    Args:
        robot: The robot, not compiled yet.
        parameters: Parameters of its gripper.

    Raises:
        RobotError: If the travel is missing, or was measured with another model or other keys.
    """
    description, travel = robot.description, parameters.travel
    command = f"bt-manip robot measure {description.source or description.name}"
    key = f"{description.where}: key 'gripper.travel'"
    if travel is None:
        assert description.gripper is not None
        file = description.gripper.parameters.get("travel")
        where = f" (no file {file})" if isinstance(file, str) else ""
        raise RobotError(f"{key} is missing{where}: '{command}' measures the fingers' travel")
    digests = travel_digests(robot, parameters)
    changed = [part for part, digest in digests.items() if travel.digests.get(part) != digest]
    if changed:
        raise RobotError(
            f"{key} was measured with other {' and '.join(changed)}; '{command}' measures it again"
        )
    return travel


def travel_digests(robot: Robot, parameters: TwoFingerParameters) -> dict[str, str]:
    """Return a digest of each part on which the travel of the fingers depends.

    The parts of the model are those of the gripper's file, or of the arm's beyond its last joint,
    with the attributes of their default classes. Meshes count by content; colours do not.

    Args:
        robot: The robot, not compiled yet.
        parameters: Parameters of its gripper.

    Returns:
        SHA-256 digests, of which the first 16 digits, by ``"bodies"``, ``"joints"``,
        ``"couplings"``, ``"tool frame"`` and ``"keys"``.
    """
    hand = robot.gripper_root
    default, compiler, world, equality, tendon, actuator = (
        getattr(hand, section).to_xml(precision=_DIGITS)
        for section in ("default", "compiler", "worldbody", "equality", "tendon", "actuator")
    )
    default.attrib.pop("class", None)  # the name of the main class, which most elements have
    defaults = dict(_classes(default, {}))
    arm = {joint.full_identifier for joint in robot.arm_joints}
    if hand is robot.mjcf_model:
        last = robot.arm_joints[-1].parent.full_identifier
        world = next(body for body in world.iter("body") if body.get("name") == last)
        for key in set(world.attrib) - {"name", "childclass"}:
            del world.attrib[key]  # its pose
    coupling = [*equality.iter(), *tendon.iter()]
    sites = {element.get(key) for element in coupling for key in ("site", "site1", "site2")}
    bodies, joints = [_line(compiler, defaults)], []
    for element in world.iter():
        if element.tag in _JOINTS:
            if element.get("name") not in arm:
                joints.append(f"{element.getparent().get('name')} {_line(element, defaults)}")
        elif element.tag != "site" or element.get("name") in sites:
            bodies.append(_line(element, defaults))
    for name in sorted({geom.get("mesh", "") for geom in world.iter("geom")} - {""}):
        bodies.append(_line(hand.find("mesh", name).to_xml(precision=_DIGITS), defaults))
    couplings = [_line(element, defaults, "equality") for element in equality.iter()]
    couplings += [_line(element, defaults, "tendon") for element in tendon.iter()]
    moved = [(motor.get("joint"), motor.get("tendon")) for motor in actuator]
    couplings += [f"{joint} {tendon}" for joint, tendon in moved if joint not in arm]
    parts = {
        "bodies": bodies,
        "joints": joints,
        "couplings": couplings,
        "tool frame": [_tool(robot, parameters.joints[0])],
        "keys": [f"{key} {getattr(parameters, key)!r}" for key in _KEYS],
    }
    return {
        part: hashlib.sha256("\n".join(lines).encode()).hexdigest()[:_LENGTH]
        for part, lines in parts.items()
    }


def _classes(default: Any, inherited: Defaults) -> Iterator[tuple[str, Defaults]]:
    """Yield the name of a default class and its attributes by tag, then the classes inside."""
    own = dict(inherited)
    for element in default:
        if element.tag != "default":
            own[element.tag] = own.get(element.tag, {}) | dict(element.attrib)
    yield default.get("class", ""), own
    for inner in default.iterchildren("default"):
        yield from _classes(inner, own)


def _line(element: Any, defaults: Mapping[str, Defaults], tag: str = "") -> str:
    """Return the tag and the attributes of an element, with those of its default class.

    Args:
        element: The element.
        defaults: The default classes.
        tag: Tag in these; default: that of the element.
    """
    classes = [element.get("class"), *(e.get("childclass") for e in element.iterancestors())]
    own = defaults.get(next(filter(None, classes), ""), defaults[""]).get(tag or element.tag, {})
    attributes = sorted((own | dict(element.attrib)).items())
    return f"{element.tag} {[pair for pair in attributes if pair[0] not in _IGNORED]}"


def _tool(robot: Robot, joint: str) -> str:
    """Return the pose of the tool in the body that carries a finger, with the joints at zero."""
    alone, data = robot.alone, mujoco.MjData(robot.alone)
    mujoco.mj_kinematics(alone, data)
    finger = alone.body(robot.find("joint", joint).parent.full_identifier).id
    tool = alone.body(robot.tool_site.parent.full_identifier).id
    T_wc, T_wb = (
        spatial.pose(data.xpos[body], data.xquat[body])
        for body in (alone.body_parentid[finger], tool)
    )
    T_ct = T_wc.inverse() * T_wb * site_pose(alone, robot.tool_site)
    numbers = [*T_ct.translation, *T_ct.rotation.ravel()]
    return " ".join(f"{x:.{_DECIMALS}f}".replace("-0.000000", "0.000000") for x in numbers)
