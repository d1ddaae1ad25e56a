"""Description of a robot from its model."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.cell import literal_name
from bt_manip.collision import CollisionWorld, permanent_self_collisions
from bt_manip.registry import Parts
from bt_manip.robots import (
    Robot,
    RobotDescription,
    RobotError,
    Tolerance,
    ToolLimits,
    model_file,
    read_model,
)
from bt_manip.toml import toml_text, write_fields
from bt_manip_setup.finger_travel import TRAVEL_NOTE, measured

from .arm_chain import find_arm, find_mount
from .gripper_keys import CHOSEN, has_two_fingers, with_gripper
from .inspection import make_robot, stands_on
from .joint_data import chosen_armature, estimate_efforts, joint_data
from .linkage import touching_links
from .placement import find_home, place_base
from .reach import DownwardReach

_ANY_EFFORT = 1e4  # [N m] placeholder until efforts are estimated
_FEW_JOINTS = Tolerance(position=1e-4, rotation=5e-3)
"""For arms with fewer than six joints, which cannot follow a gripped object that tilts."""

_TOOL_LIMITS = ToolLimits(velocity=1.0, acceleration=5.0, jerk=500.0)


def description_text(
    description: RobotDescription, notes: Mapping[str, str], file: Path, head: str
) -> str:
    """Return a description as TOML that `bt_manip.robots.read_description` reads.

    Args:
        description: The description.
        notes: Comments by key, such as ``"velocity"`` and ``"gripper.max_force"``.
        file: The file, to whose folder paths of models are relative.
        head: Comment at the beginning.
    """
    entries = write_fields(description, file.resolve().parent)
    if description.name == file.stem:
        del entries["name"]
    return toml_text(entries, notes, head)


class Draft(NamedTuple):
    """The description of a robot, with comments on its keys.

    Attributes:
        description: The description.
        notes: Comments by key.
        robot: The robot, compiled alone.
    """

    description: RobotDescription
    notes: dict[str, str]
    robot: Robot


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
    at, joint_ids = find_mount(alone, arm, mount), list(arm.joints)
    middle = np.where(alone.jnt_limited[joint_ids], alone.jnt_range[joint_ids].mean(axis=1), 0.0)
    description = RobotDescription(
        name=name,
        model=model,
        arm_joints=tuple(literal_name(alone.joint(j).name) for j in arm.joints),
        tool_frame=tool_frame or at,
        home=tuple(middle.tolist()),
        velocity=data.velocity,
        acceleration=data.acceleration,
        jerk=data.jerk,
        effort=tuple(_ANY_EFFORT if bound is None else bound for bound in data.effort),
        tool_limits=_TOOL_LIMITS,
        tolerance=_FEW_JOINTS if len(arm.joints) < 6 else Tolerance(),
    )
    notes = {
        "acceleration": f"{CHOSEN} if it has any [rad/s2].",
        "jerk": "CHOSEN: the acceleration is reached in 20 ms [rad/s3].",
        "tool_limits": "CHOSEN: limits of the tool along a line [m/s], [m/s2], [m/s3].",
        "tolerance": "CHOSEN: five joints cannot follow a gripped object that tilts [m], [rad].",
        "velocity": "From the model [rad/s]." if data.velocity_known else f"{CHOSEN} [rad/s].",
    }
    description, of_gripper = with_gripper(
        description, parts, alone, gripper,
        mount=at, tool_frame=tool_frame, has_fingers=bool(arm.fingers),
    )  # fmt: skip
    notes |= of_gripper
    if has_two_fingers(description, parts):
        description, notes["gripper.travel"] = measured(description), TRAVEL_NOTE
        links = touching_links(make_robot(description, parts))
        description = replace(description, exclude=tuple(links))
    robot = make_robot(description, parts)
    overlaps = permanent_self_collisions(CollisionWorld(robot, robot.make_model()))
    if overlaps:
        description = replace(description, exclude=(*description.exclude, *overlaps))
        robot = make_robot(description, parts)
    if description.exclude:
        notes["exclude"] = (
            "CHOSEN: bodies that overlap in all of many random configurations, and links of the "
            "gripper, except its fingers, that touch at some opening."
        )
    effort = None
    if None in data.effort:
        estimated = estimate_efforts(robot.make_model())
        effort = tuple(
            guess if bound is None else bound
            for guess, bound in zip(estimated, data.effort, strict=True)
        )
        notes["effort"] = f"{CHOSEN} [N m]; enough to hold and accelerate the arm."
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
            f"{CHOSEN} [kg m2].\nJoints of almost no inertia have 1e-3 kg m2 for each N m of "
            "their effort limit, the others the model's."
        )
        robot = make_robot(description, parts)
    if robot.warnings:
        notes["model"] = "CHOSEN where the model has none or an impossible one:\n" + "\n".join(
            robot.warnings
        )
    return Draft(description, notes, robot)
