"""The keys ``[gripper]`` and ``[tool]`` of a description."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import escaped_name, literal_name
from bt_manip.grippers import TwoFingerGripper, collision_geoms_of, two_finger_gripper
from bt_manip.registry import Parts
from bt_manip.robots import (
    MENAGERIE,
    FoundGripper,
    Gripper,
    GripperDescription,
    RobotDescription,
    RobotError,
    assemble,
    site_pose,
)
from bt_manip_setup.finger_travel import OverlappingHullsError, find_fingers

from .known_grippers import CUP, find_gripper
from .linkage import concave_bodies

CHOSEN = "CHOSEN, not in the model: replace by the data sheet's"
"""Begins the comment on a value that the model does not have."""

_FORCE, _FINGER_SPEED = 50.0, 0.1  # [N], [m/s] if the model has none
_PADS = {"solref": [0.004, 1.0], "solimp": [0.95, 0.99, 0.001]}
_MAX_FRICTION = 5.0  # [N] at the fingers, from dry friction of the gripper's joints
_MAX_MASS = 3.0  # [kg] effective mass of a finger, with the armature of its joints
_FINGER_ARMATURE = 0.005  # [kg m2] in place of a larger armature
_MIN_MASS = 0.3  # [kg] effective mass of a finger on hinges that control and grip need
_LINK_ARMATURE = 1e-3  # [kg m2] of each hinge of a lighter linkage
_CONVEX_NOTE = "Concave bodies of the gripper, whose hulls overlap at every opening."
_CUP = {"diameter": 0.03, "pressure": 6e4, "length": 0.05}  # [m], [Pa], [m] of a built cup
_SAME = 1e-6  # largest difference of equal rotations
_ALONG = 0.9  # least cosine of directions that count as parallel


def with_gripper(
    description: RobotDescription,
    parts: Parts,
    arm: mujoco.MjModel,
    given: str | None,
    *,
    mount: str,
    tool_frame: str | None,
    has_fingers: bool,
) -> tuple[RobotDescription, dict[str, str]]:
    """Return a description with gripper and tool frame, and comments on these keys.

    A registered gripper keeps its parameters; that of another model, or of the arm's, is measured.
    Without any gripper the description stays as it is.

    Args:
        description: The description of the arm.
        parts: The registered parts, among them the kinds of grippers.
        arm: The arm's model, compiled alone.
        given: Name or model of a gripper; None: that of the arm's model, if it has one.
        mount: Site or body at which a gripper is mounted.
        tool_frame: Site or body between the fingers; None: measured.
        has_fingers: Whether the arm's model has joints beyond the arm.

    Raises:
        RobotError: If the gripper cannot be found; the message names the option to give it.
    """
    if given is None and not has_fingers and _cup(arm) is None:
        return description, {}
    known = None
    if given is not None:
        given, known = find_gripper(given, parts)
    if given == CUP:
        described = replace(
            description,
            tool_frame=mount,
            T_ft=spatial.pose((0.0, 0.0, _CUP["length"])),
            gripper=GripperDescription(kind=CUP, parameters=_CUP),
        )
        return described, {"gripper": "CHOSEN: a cup of 3 cm, built at the mount."}
    if given is not None and known is not None:
        notes = {"gripper": f"Gripper of the registered robot {known.name}."}
        return replace(description, **_registered(arm, description, known, given)), notes
    try:
        return _measured(description, given, mount, tool_frame, parts)
    except RobotError as error:
        joints = ",".join(description.arm_joints)
        kinds = ", ".join(sorted({*parts.grippers} - {"two_finger", CUP}))
        others = kinds and f"; for another kind ({kinds}) give a registered gripper's name"
        raise RobotError(f"{error}{others} (the arm: --joints {joints})") from error


def has_two_fingers(description: RobotDescription, parts: Parts) -> bool:
    """Return whether a description has a gripper with two fingers."""
    kind = description.gripper and parts.grippers.get(description.gripper.kind)
    return isinstance(kind, type) and issubclass(kind, TwoFingerGripper)


def _registered(
    model: mujoco.MjModel, description: RobotDescription, known: RobotDescription, given: str
) -> dict[str, Any]:
    """Return the tool and the gripper of a registered robot, for the mount of another arm."""
    gripper, mount = known.gripper, description.tool_frame
    assert gripper is not None and gripper.model is not None
    is_file = given.startswith(MENAGERIE) or Path(given).is_file()
    carried = replace(
        gripper,
        model=given if is_file else gripper.model,
        mount=mount,
        T_mg=_outwards(model, description, mount) * gripper.T_mg,
        file=None,
    )
    return {"tool_frame": known.tool_frame, "T_ft": known.T_ft, "gripper": carried}


def _cup(model: mujoco.MjModel) -> int | None:
    """Return the body of the first adhesion actuator; None without one."""
    cups = np.flatnonzero(model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_BODY))
    return int(model.actuator_trnid[cups[0], 0]) if cups.size else None


def _measured(
    description: RobotDescription,
    model: str | None,
    mount: str,
    tool_frame: str | None,
    parts: Parts,
) -> tuple[RobotDescription, dict[str, str]]:
    """Return the description with the gripper and the tool frame, and comments on them."""
    names = [escaped_name(joint) for joint in description.arm_joints]
    carried = GripperDescription(model=model, mount=mount if model else None)
    assembled = assemble(replace(description, gripper=carried if model else None))
    prefix = assembled.gripper.full_identifier if model else ""

    def local(full: str) -> str:
        return literal_name(full.removeprefix(prefix))

    cup = _cup(assembled.alone)
    if cup is not None:
        sites = np.flatnonzero(assembled.alone.site_bodyid == cup)
        if tool_frame is None and len(sites) != 1:
            body = local(assembled.alone.body(cup).name)
            raise RobotError(
                f"{model or description.model}: the suction cup '{body}' has {len(sites)} sites: "
                "name the one at its lip whose z axis is the cup's (--tool-frame)"
            )
        frame = tool_frame or local(assembled.alone.site(sites[0]).name)
        return replace(description, tool_frame=frame, gripper=replace(carried, kind=CUP)), {}
    tool = None
    if tool_frame is not None:
        site = assembled.tool_site
        tool = site.parent.full_identifier, site_pose(assembled.alone, site)
    try:
        found = find_fingers(assembled.alone, names, tool=tool, where=model or description.model)
    except RobotError as error:
        other = _of_another_kind(assembled.alone, names, parts)
        if isinstance(error, OverlappingHullsError) and find_spec("coacd"):
            concave = concave_bodies(assembled.alone, names[-1])
            if concave and not description.convex_parts:
                description = replace(description, convex_parts=concave)
                described, notes = _measured(description, model, mount, tool_frame, parts)
                return described, notes | {"convex_parts": _CONVEX_NOTE}
        if other is None:
            raise
        kind, hand = other
        known = {key: _renamed(value, local) for key, value in hand.parameters.items()}
        gripper = replace(carried, kind=kind, max_force=hand.max_force, parameters=known)
        if model is not None:
            pose = standing_pose(assembled.alone, description, hand)
            gripper = replace(gripper, T_mg=pose)
        described = replace(
            description, gripper=gripper, tool_frame=local(hand.body), T_ft=hand.T_bt
        )
        return described, dict(hand.notes)
    notes = {"gripper": "Measured on the model.", "gripper.max_speed": f"{CHOSEN} [m/s]."}
    notes["gripper.max_force"] = "Force of the model's actuator at each finger [N]."
    force = found.max_force
    if force is None:
        force, notes["gripper.max_force"] = _FORCE, f"{CHOSEN} [N]."
    travel, changes = found.travel, {}
    if travel.friction > _MAX_FRICTION:
        changes["frictionloss"] = 0.0
        notes["gripper.frictionloss"] = (
            f"The model's dry friction would take {travel.friction:.0f} N of the fingers."
        )
    if travel.mass > _MAX_MASS:
        changes["armature"] = _FINGER_ARMATURE
        notes["gripper.armature"] = (
            f"With the model's armature, the effective mass of a finger is {travel.mass:.0f} kg."
        )
    elif 0.0 < travel.mass < _MIN_MASS and all(
        assembled.alone.joint(name).type[0] == mujoco.mjtJoint.mjJNT_HINGE for name in travel.joints
    ):
        changes["armature"] = _LINK_ARMATURE
        notes["gripper.armature"] = (
            "CHOSEN: with the model's inertia, the effective mass of a finger is "
            f"{travel.mass:.2g} kg, too little for a stiff grip [kg m2]."
        )
    R_wt = _rotation(assembled.alone, found.body, found.T_bt)
    gripper = two_finger_gripper(
        joints=[local(joint) for joint in found.joints],
        fingers=[local(finger) for finger in found.fingers],
        motor=None if found.motor is None else local(found.motor),
        open_width=float(np.floor(1e4 * travel.open_width) / 1e4),
        max_speed=_FINGER_SPEED,
        max_force=float(f"{force:.2g}"),
        pads=_PADS,
        model=model,
        mount=carried.mount,
        T_mg=None if model is None else _outwards(assembled.alone, description, mount, R_wt[:, 2]),
        **changes,
    )
    if tool_frame is None:
        notes["tool"] = "Between the finger pads; z is the direction of approach."
        description = replace(description, tool_frame=local(found.body), T_ft=found.T_bt)
    elif tool is not None:
        turn = pin.SE3(_rotation(assembled.alone, *tool).T @ R_wt, np.zeros(3))
        if not turn.isIdentity(_SAME):
            notes["tool"] = "The rotation makes z the direction of approach of the fingers."
            description = replace(description, T_ft=turn)
    return replace(description, gripper=gripper), notes


def _rotation(model: mujoco.MjModel, body: str, T: pin.SE3) -> np.ndarray:
    """Return the rotation in the world of a frame given by its pose in a body."""  # (3, 3)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return np.array(data.body(body).xmat.reshape(3, 3) @ T.rotation)


def _of_another_kind(
    model: mujoco.MjModel, arm_joints: Sequence[str], parts: Parts
) -> tuple[str, FoundGripper] | None:
    """Return the first registered gripper kind that recognises its gripper in a model."""
    for name in parts.grippers:
        kind = parts.grippers.get(name)
        if isinstance(kind, type) and issubclass(kind, Gripper):
            found = kind.found_in(model, arm_joints)
            if found is not None:
                return name, found
    return None


def _renamed(value: Any, local: Callable[[str], str]) -> Any:
    """Return a parameter with names as in the model file."""
    if isinstance(value, str):
        return local(value)
    return [_renamed(item, local) for item in value] if isinstance(value, list) else value


def standing_pose(
    model: mujoco.MjModel, description: RobotDescription, found: FoundGripper
) -> pin.SE3:
    """Return the pose in its mount of a gripper that stands on it, z outwards.

    What of its body is below the origin is lifted onto the mount, the description's tool frame.
    """
    low = 0.0
    for geom in collision_geoms_of(model, model.body(found.body).id):
        T = spatial.pose(model.geom_pos[geom], model.geom_quat[geom])
        middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        low = min(low, float(T.act(middle)[2] - np.abs(T.rotation[2]) @ half))
    turn = _outwards(model, description, description.tool_frame)
    return turn * spatial.pose((0.0, 0.0, round(-low, 3)))


def _outwards(
    model: mujoco.MjModel,
    description: RobotDescription,
    mount: str,
    approach: np.ndarray | None = None,
) -> pin.SE3:
    """Return the rotation in a mount that turns a direction away from the arm.

    Away is along the axis of the last joint, from the last links to the mount. If the z axis of the
    mount is not parallel to it, away is that z axis. The direction is approximate and in the world;
    by default it is the mount's z axis.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    joints = [model.joint(escaped_name(name)).id for name in description.arm_joints]
    site = mujoco.mj_name2id(model, int(mujoco.mjtObj.mjOBJ_SITE), escaped_name(mount))
    at, R = (
        (data.site_xpos[site], data.site_xmat[site])
        if site >= 0
        else (data.body(escaped_name(mount)).xpos, data.body(escaped_name(mount)).xmat)
    )
    R_wm = R.reshape(3, 3)
    outwards = R_wm[:, 2]
    axis = data.xaxis[joints[-1]]
    if abs(axis @ outwards) > _ALONG:
        along = [float((at - data.xanchor[j]) @ axis) for j in reversed(joints)]
        outwards = np.sign(next((d for d in along if abs(d) > 1e-3), 1.0)) * axis
    if approach is None:
        approach = R_wm[:, 2]
    elif approach @ outwards > _ALONG:
        return pin.SE3.Identity()
    turn = pin.Quaternion.FromTwoVectors(R_wm.T @ approach, R_wm.T @ outwards)
    return pin.SE3(turn.matrix(), np.zeros(3))
