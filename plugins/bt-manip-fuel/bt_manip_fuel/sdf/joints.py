"""Joints of SDF as joints of MJCF."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip_fuel.sdf.reader import Element, SdfReader
from bt_manip_fuel.sdf.scopes import Frame, Scopes

_TYPES = {
    "revolute": ("hinge", ("axis",)),
    "continuous": ("hinge", ("axis",)),
    "prismatic": ("slide", ("axis",)),
    "universal": ("hinge", ("axis", "axis2")),
    "revolute2": ("hinge", ("axis", "axis2")),
    "ball": ("ball", ()),
    "fixed": ("", ()),
}
_KNOWN = {"parent", "child", "pose", "axis", "axis2", "thread_pitch", "physics"}
_UNBOUNDED = 1e15  # SDF's default is 1e16
_FAR = 1e6  # [rad, m] limit on an unlimited side


class JointElement(NamedTuple):
    """A joint in MJCF, and the equality by which it follows another joint."""

    attributes: dict[str, object]
    equality: dict[str, object] | None = None


def joints_of(
    reader: SdfReader, scopes: Scopes, name: str, frame: Frame, child: str
) -> list[JointElement]:
    """Return the MJCF joints of an SDF joint, in kinematic order.

    Args:
        reader: Reads values.
        scopes: The frames.
        name: Name of the joint.
        frame: The joint.
        child: The moved link.

    Raises:
        ModelError: If an axis or a number is invalid.
    """
    element = frame.element
    reader.only(element, _KNOWN)
    kind = element.get("type", "")
    if kind not in _TYPES:
        reader.warn(element, f"a joint of type '{kind}' cannot be expressed; it is held fixed")
        return []
    mjcf_type, axes = _TYPES[kind]
    T_lj = scopes.pose(child).inverse() * scopes.pose(name)
    if mjcf_type == "ball":
        return [JointElement({"name": name, "type": "ball", "pos": T_lj.translation})]
    made = []
    for tag in axes:
        axis = element.find(tag)
        if axis is None:
            raise reader.error(element, f"joint '{name}' has no <{tag}>")
        reader.only(axis, {"xyz", "limit", "dynamics", "mimic", "use_parent_model_frame"})
        attributes: dict[str, object] = {
            "name": name if tag == "axis" else f"{name}_2",
            "type": mjcf_type,
            "pos": T_lj.translation,
            "axis": _direction(reader, scopes, frame, child, T_lj, axis),
            **_limits(reader, axis, bounded=kind != "continuous"),
            **_dynamics(reader, axis),
        }
        made.append(JointElement(attributes, _mimic(reader, scopes, frame, axis, attributes)))
    return made


def _direction(
    reader: SdfReader, scopes: Scopes, frame: Frame, child: str, T_lj: pin.SE3, axis: Element
) -> np.ndarray:
    """Return the axis in the child link's frame."""  # (3,)
    xyz = reader.vector(axis, "xyz", (0, 0, 1))
    element = axis.find("xyz")
    rotation = T_lj.rotation
    if element is not None and element.get("expressed_in"):
        base = scopes.whole_name(frame.scope, element.get("expressed_in", ""), element)
        rotation = (scopes.pose(child).inverse() * scopes.pose(base)).rotation
    elif reader.flag(axis, "use_parent_model_frame"):  # SDF 1.4
        rotation = scopes.pose(child).inverse().rotation
    if np.linalg.norm(xyz) < 1e-9:
        raise reader.error(axis, "an axis of zeros")
    return rotation @ xyz / np.linalg.norm(xyz)


def _limits(reader: SdfReader, axis: Element, *, bounded: bool) -> dict[str, object]:
    limit, attributes = axis.find("limit"), dict[str, object]()
    if limit is None:
        return attributes
    reader.only(limit, {"lower", "upper", "effort", "velocity", "stiffness", "dissipation"})
    lower = reader.number(limit, "lower", -np.inf)
    upper = reader.number(limit, "upper", np.inf)
    if bounded and (lower > -_UNBOUNDED or upper < _UNBOUNDED):
        if lower > upper:
            raise reader.error(limit, f"the lower limit {lower:g} is above the upper {upper:g}")
        attributes["range"] = (max(lower, -_FAR), max(min(upper, _FAR), lower + 1e-9))
        attributes["limited"] = "true"
    effort = reader.number(limit, "effort", np.inf)
    if 0 < effort < _UNBOUNDED:
        attributes["actuatorfrcrange"] = (-effort, effort)
        attributes["actuatorfrclimited"] = "true"
    if 0 < reader.number(limit, "velocity", np.inf) < _UNBOUNDED:
        reader.warn(limit.find("velocity"), "MuJoCo's joints have no limit of velocity")
    return attributes


def _dynamics(reader: SdfReader, axis: Element) -> dict[str, object]:
    dynamics, attributes = axis.find("dynamics"), dict[str, object]()
    if dynamics is None:
        return attributes
    known = {
        "damping": "damping", "friction": "frictionloss",
        "spring_stiffness": "stiffness", "spring_reference": "springref",
    }  # fmt: skip
    reader.only(dynamics, known)
    for tag, attribute in known.items():
        value = reader.number(dynamics, tag, 0.0)
        if not np.isfinite(value) or (value < 0 and tag != "spring_reference"):
            raise reader.error(dynamics, f"<{tag}> must not be negative, got {value:g}")
        if value:
            attributes[attribute] = value
    return attributes


def _mimic(
    reader: SdfReader, scopes: Scopes, frame: Frame, axis: Element, follower: dict[str, object]
) -> dict[str, object] | None:
    """Return the equality ``q = multiplier * (leader - reference) + offset``."""
    mimic = axis.find("mimic")
    if mimic is None:
        return None
    leader = scopes.whole_name(frame.scope, mimic.get("joint", ""), mimic)
    multiplier = reader.number(mimic, "multiplier", 1.0)
    reference = reader.number(mimic, "reference", 0.0)
    offset = reader.number(mimic, "offset", 0.0) - multiplier * reference
    return {"joint1": follower["name"], "joint2": leader, "polycoef": (offset, multiplier, 0, 0, 0)}
