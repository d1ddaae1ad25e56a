"""Description of a robot from its model."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import escaped_name, literal_name
from bt_manip.collision import CollisionWorld, permanent_self_collisions
from bt_manip.grippers import (
    DEFAULT_LENGTH,
    TwoFingerGripper,
    suction_gripper,
    two_finger_gripper,
)
from bt_manip.registry import Parts
from bt_manip.robots import (
    MENAGERIE,
    FoundGripper,
    Gripper,
    GripperDescription,
    Robot,
    RobotDescription,
    RobotError,
    Tolerance,
    ToolLimits,
    assemble,
    model_file,
    read_model,
    site_pose,
)
from bt_manip_setup.finger_travel import TRAVEL_NOTE, find_fingers, measured

from .arm_chain import ArmChain, find_arm, find_mount
from .inspection import make_robot, stands_on
from .joint_data import chosen_armature, estimate_efforts, joint_data
from .known_grippers import CUP, find_gripper
from .placement import find_home, place_base
from .reach import DownwardReach

_FORCE, _FINGER_SPEED = 50.0, 0.1  # [N], [m/s] if the model has none
_PADS = {"solref": [0.004, 1.0], "solimp": [0.95, 0.99, 0.001]}
_ANY_EFFORT = 1e4  # [N m] placeholder until efforts are estimated
_FEW_JOINTS = Tolerance(position=1e-4, rotation=5e-3)
"""For arms with fewer than six joints, which cannot follow a gripped object that tilts."""

_TOOL_LIMITS = ToolLimits(velocity=1.0, acceleration=5.0, jerk=500.0)
_MAX_FRICTION = 5.0  # [N] at the fingers, from dry friction of the gripper's joints
_MAX_MASS = 3.0  # [kg] effective mass of a finger, with the armature of its joints
_FINGER_ARMATURE = 0.005  # [kg m2] in place of a larger armature
_CUP_DIAMETER, _CUP_PRESSURE = 0.03, 6e4  # [m], [Pa] of a built cup
_SAME = 1e-6  # largest difference of equal rotations
_ALONG = 0.9  # least cosine of directions that count as parallel

_CHOSEN = "CHOSEN, not in the model: replace by the data sheet's"


class Draft(NamedTuple):
    """The description of a robot, with comments on its keys.

    Attributes:
        description: The description.
        notes: Comments by key.
        robot: The robot, compiled alone.
        share: Share of the positions of the pick and place task within reach.
    """

    description: RobotDescription
    notes: dict[str, str]
    robot: Robot
    share: float


def describe_robot(
    model: str,
    parts: Parts,
    *,
    name: str,
    gripper: str | None = None,
    joints: Sequence[str] | None = None,
    mount: str | None = None,
    tool_frame: str | None = None,
) -> Draft:
    """Describe a robot from its model, for the pick and place task.

    Args:
        model: Path of the arm's MJCF or URDF file, or ``menagerie:NAME/ENTRY``.
        parts: The registered parts, among them the kinds of grippers.
        name: Name of the robot.
        gripper: Model of a gripper, if the arm's model has none; or a name of
            `gripper_names`.
        joints: Names of the arm's joints; default: found in the model.
        mount: Site or body at which the gripper is mounted; default: found in the model.
        tool_frame: Site or body between the fingers whose z axis is the direction of approach;
            default: measured.

    Raises:
        RobotError: If a part cannot be found; the message names the option to give it.
    """
    _, alone = read_model(model, model)
    arm = find_arm(alone, joints)
    if gripper is not None and arm.fingers:
        own = literal_name(alone.joint(arm.fingers[0]).name)
        raise RobotError(
            f"{model} has a gripper of its own, with joint '{own}': leave out --gripper, or choose "
            "a model of the arm without it"
        )
    data = joint_data(alone, arm.joints, model_file(model, model))
    at = find_mount(alone, arm, mount)
    description = RobotDescription(
        name=name,
        model=model,
        arm_joints=tuple(literal_name(alone.joint(j).name) for j in arm.joints),
        tool_frame=tool_frame or at,
        home=tuple(_middle(alone, arm).tolist()),
        velocity=data.velocity,
        acceleration=data.acceleration,
        jerk=data.jerk,
        effort=tuple(_ANY_EFFORT if bound is None else bound for bound in data.effort),
        tool_limits=_TOOL_LIMITS,
        tolerance=_FEW_JOINTS if len(arm.joints) < 6 else Tolerance(),
    )
    notes = {
        "acceleration": f"{_CHOSEN} if it has any [rad/s2].",
        "jerk": "CHOSEN: the acceleration is reached in 20 ms [rad/s3].",
        "tool_limits": "CHOSEN: limits of the tool along a line [m/s], [m/s2], [m/s3].",
        "tolerance": "CHOSEN: five joints cannot follow a gripped object that tilts [m], [rad].",
        "velocity": "From the model [rad/s]." if data.velocity_known else f"{_CHOSEN} [rad/s].",
    }
    known = None
    if gripper is not None:
        gripper, known = find_gripper(gripper, parts)
    if gripper == CUP:
        description = replace(description, **_built_cup(at))
        notes["gripper"] = "CHOSEN: a cup of 3 cm, built at the mount."
    elif gripper is not None and known is not None:
        description = replace(description, **_registered(alone, description, known, gripper))
        notes["gripper"] = f"Gripper of the registered robot {known.name}."
    elif gripper is not None or arm.fingers or _cup(alone) is not None:
        try:
            description, more = _with_gripper(description, gripper, at, tool_frame, parts)
        except RobotError as error:
            joints_of_arm = ",".join(description.arm_joints)
            kinds = ", ".join(sorted({*parts.grippers} - {"two_finger", "suction"}))
            others = kinds and f"; for another kind ({kinds}) give a registered gripper's name"
            raise RobotError(f"{error}{others} (the arm: --joints {joints_of_arm})") from error
        notes |= more
    if _has_two_fingers(description, parts):
        description, notes["gripper.travel"] = measured(description), TRAVEL_NOTE
    robot = make_robot(description, parts)
    overlaps = permanent_self_collisions(CollisionWorld(robot, robot.make_model()))
    if overlaps:
        description = replace(description, exclude=tuple(overlaps))
        notes["exclude"] = "Bodies that overlap in every configuration of the model."
        robot = make_robot(description, parts)
    effort = None
    if None in data.effort:
        estimated = estimate_efforts(robot.make_model())
        effort = tuple(
            guess if bound is None else bound
            for guess, bound in zip(estimated, data.effort, strict=True)
        )
        notes["effort"] = f"{_CHOSEN} [N m]; enough to hold and accelerate the arm."
    downward = DownwardReach(robot, robot.make_model())
    reach = downward.measure()
    if not reach.reached(-np.inf).any():
        find_home(downward, reach, pin.SE3.Identity())  # raises, with the remedy
    placement = place_base(robot, reach)
    home = find_home(downward, reach, placement.T_rb)
    notes["home"] = "The tool points down over the middle of its reach."
    description = replace(
        description,
        T_rb=placement.T_rb,
        pedestal=placement.pedestal,
        home=tuple(np.round(home, 4).tolist()),
        effort=effort,
    )
    notes["base"] = f"The base stands {stands_on(description)}: the table suits the reach so."
    robot = make_robot(description, parts)
    own = robot.mj_model.dof_armature[robot.dof_adr]
    armature = chosen_armature(robot.make_model(), own)
    if armature is not None:
        description = replace(description, armature=armature)
        notes["armature"] = (
            f"{_CHOSEN} [kg m2].\nJoints of almost no inertia have 1e-3 kg m2 for each N m of "
            "their effort limit, the others the model's."
        )
        robot = make_robot(description, parts)
    return Draft(description, notes, robot, placement.share)


def _has_two_fingers(description: RobotDescription, parts: Parts) -> bool:
    kind = description.gripper and parts.grippers.get(description.gripper.kind)
    return isinstance(kind, type) and issubclass(kind, TwoFingerGripper)


def _built_cup(mount: str) -> dict[str, Any]:
    """Return the tool and a suction cup built at the mount."""
    return {
        "tool_frame": mount,
        "T_ft": spatial.pose((0.0, 0.0, DEFAULT_LENGTH)),
        "gripper": suction_gripper(diameter=_CUP_DIAMETER, pressure=_CUP_PRESSURE),
    }


def _registered(
    model: mujoco.MjModel, description: RobotDescription, known: RobotDescription, given: str
) -> dict[str, Any]:
    """Return the tool and the gripper of a registered robot, for the mount of another arm.

    Args:
        model: The arm, compiled alone.
        description: Its description, with the mount as the tool frame.
        known: The registered robot.
        given: The gripper as given by the user: a name or a model.
    """
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


def _middle(model: mujoco.MjModel, arm: ArmChain) -> np.ndarray:
    joints = list(arm.joints)
    return np.where(model.jnt_limited[joints], model.jnt_range[joints].mean(axis=1), 0.0)


def _with_gripper(
    description: RobotDescription,
    model: str | None,
    mount: str,
    tool_frame: str | None,
    parts: Parts,
) -> tuple[RobotDescription, dict[str, str]]:
    """Return the description with the gripper and the tool frame, and comments on them."""
    names = [escaped_name(joint) for joint in description.arm_joints]
    carried = None if model is None else GripperDescription(model=model, mount=mount)
    assembled = assemble(replace(description, gripper=carried))
    prefix = "" if model is None else assembled.gripper.full_identifier

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
        gripper = suction_gripper(model=model, mount=mount if model else None)
        return replace(description, tool_frame=frame, gripper=gripper), {}
    tool = None
    if tool_frame is not None:
        site = assembled.tool_site
        tool = site.parent.full_identifier, site_pose(assembled.alone, site)
    try:
        found = find_fingers(assembled.alone, names, tool=tool, where=model or description.model)
    except RobotError:
        other = _of_another_kind(assembled.alone, names, parts)
        if other is None:
            raise
        kind, hand = other
        known = {key: _renamed(value, local) for key, value in hand.parameters.items()}
        gripper = GripperDescription(
            kind=kind,
            max_force=hand.max_force,
            parameters=known,
            model=model,
            mount=mount if model else None,
            T_mg=pin.SE3.Identity()
            if model is None
            else _standing(assembled.alone, description, hand),
        )
        described = replace(
            description, gripper=gripper, tool_frame=local(hand.body), T_ft=hand.T_bt
        )
        return described, dict(hand.notes)
    notes = {"gripper": "Measured on the model.", "gripper.max_speed": f"{_CHOSEN} [m/s]."}
    notes["gripper.max_force"] = "Force of the model's actuator at each finger [N]."
    force = found.max_force
    if force is None:
        force, notes["gripper.max_force"] = _FORCE, f"{_CHOSEN} [N]."
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
        mount=mount if model else None,
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


def _standing(model: mujoco.MjModel, description: RobotDescription, found: FoundGripper) -> pin.SE3:
    """Return the pose in its mount of a gripper that stands on it, z outwards."""
    body = model.body(found.body).id
    own = (model.geom_bodyid == body) & (model.geom_contype | model.geom_conaffinity != 0)
    low = 0.0
    for geom in np.flatnonzero(own):
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, model.geom_quat[geom])
        middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        z = R.reshape(3, 3)[2]
        low = min(low, float(model.geom_pos[geom, 2] + z @ middle - np.abs(z) @ half))
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
    mount is not parallel to it, away is that z axis.

    Args:
        model: The arm, compiled alone.
        description: Its description.
        mount: Name of the mount.
        approach: The direction in the world, approximately; default: the mount's z
            axis.  # (3,)
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
