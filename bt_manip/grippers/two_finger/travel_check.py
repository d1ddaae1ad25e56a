"""Check that a measured travel fits the gripper's model and description."""

import hashlib
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from bt_manip import spatial
from bt_manip.robots import Robot, RobotError, site_pose

from .finger_travel import FingerTravel
from .parameters import TwoFingerParameters

_KEYS = ("joints", "fingers", "motor", "armature", "frictionloss")
_IGNORED = (
    "dclass", "childclass", "group", "material", "rgba", "user",
    "assetdir", "meshdir", "texturedir",
)  # fmt: skip
_SITES = ("site", "site1", "site2")
_JOINTS = ("joint", "freejoint")
_DIGITS = 9  # significant digits of the model's numbers
_DECIMALS = 6  # [m] and of quaternions, of the tool frame, which is computed
_LENGTH = 16  # hexadecimal digits of a digest


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
    with the attributes of their default classes. Meshes count by their bounding boxes to 0.1 mm, so
    that another writing of the same mesh is the same. Colours do not count, nor do shapes that
    neither collide nor have mass.

    Args:
        robot: The robot, not compiled yet.
        parameters: Parameters of its gripper.

    Returns:
        SHA-256 digests, of which the first 16 digits, by ``"bodies"``, ``"joints"``,
        ``"couplings"``, ``"tool frame"`` and ``"keys"``.
    """
    hand, arm = robot.gripper_root, robot.arm_joints
    base = hand.worldbody if hand is not robot.mjcf_model else arm[-1].parent
    coupled = [c for section in (hand.equality, hand.tendon) for c in section.all_children()]
    wraps = [w for tendon in hand.tendon.all_children() for w in tendon.all_children()]
    sites = [getattr(c, key, None) for c in (*coupled, *wraps) for key in _SITES]
    bodies, joints, meshes = [_line(hand.compiler)], [], {}
    for element, childclass in _elements(base):
        if _is_drawn_only(element, childclass):
            continue
        line = _line(element, childclass)
        if element.tag in _JOINTS:
            if not any(element is joint for joint in arm):
                joints.append(f"{element.parent.name} {line}")
        elif element.tag != "site" or any(element is site for site in sites):
            bodies.append(line)
        mesh = element.mesh if element.tag == "geom" else None
        if mesh is not None:
            meshes[mesh.name] = _box(robot.alone, mesh)
    bodies += meshes.values()
    couplings = [_line(c, tag=c.parent.tag) for c in coupled] + [_line(wrap) for wrap in wraps]
    for motor in hand.actuator.all_children():
        moved = [getattr(motor, key, None) for key in ("joint", "tendon")]
        if not any(target is joint for target in moved for joint in arm):
            couplings.append(" ".join(target.name for target in moved if target is not None))
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


def _elements(body: Any, childclass: Any = None) -> Iterator[tuple[Any, Any]]:
    """Yield the elements in a body and those in its bodies, with the default class that applies."""
    outer = body
    while childclass is None and outer.tag == "body":
        childclass, outer = outer.childclass, outer.parent
    for element in body.all_children():
        yield element, childclass
        if element.tag == "body":
            yield from _elements(element, element.childclass or childclass)


def _line(element: Any, childclass: Any = None, tag: str = "") -> str:
    """Return an element's tag and attributes, with those of its default class for the tag."""
    attributes = sorted(_attributes(element, childclass, tag or element.tag).items())
    texts = (f"{k}={_text(v)}" for k, v in attributes if k not in _IGNORED)
    return f"{element.tag} {' '.join(texts)}"


def _attributes(element: Any, childclass: Any, tag: str) -> dict[str, Any]:
    """Return an element's attributes, with those of its default class."""
    attributes = dict(element.get_attributes())
    default = attributes.get("dclass") or childclass or element.root.default
    while default.tag == "default":
        inherited = getattr(default, tag, None)
        attributes = ({} if inherited is None else dict(inherited.get_attributes())) | attributes
        default = default.parent
    return attributes


def _is_drawn_only(element: Any, childclass: Any) -> bool:
    """Return whether an element is a shape that neither collides nor gives its body mass."""
    if element.tag != "geom" or getattr(element.parent, "inertial", None) is None:
        return False
    attributes = _attributes(element, childclass, "geom")
    return attributes.get("contype", 1) == attributes.get("conaffinity", 1) == 0


def _text(value: Any) -> str:
    """Return the value of an attribute."""
    if isinstance(value, float | np.ndarray):
        return " ".join(f"{x:.{_DIGITS}g}" for x in np.ravel(value).tolist())
    return str(getattr(value, "name", value))


def _box(model: mujoco.MjModel, mesh: Any) -> str:
    """Return the name of a mesh and its bounding box [0.1 mm] in the frame of its file."""
    number = model.mesh(mesh.full_identifier).id
    first, count = model.mesh_vertadr[number], model.mesh_vertnum[number]
    # MuJoCo moves it to its centre of mass.
    T_fm = spatial.pose(model.mesh_pos[number], model.mesh_quat[number])
    vertices = model.mesh_vert[first : first + count] @ T_fm.rotation.T + T_fm.translation
    ends = np.rint(1e4 * np.concatenate([vertices.min(axis=0), vertices.max(axis=0)]))
    return f"mesh {mesh.name} {' '.join(f'{x:.0f}' for x in ends + 0.0)}"


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
