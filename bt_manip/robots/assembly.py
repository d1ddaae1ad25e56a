"""Assembly of the models of an arm and its gripper from the files in a description."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import pinocchio as pin
from dm_control import mjcf

from bt_manip import spatial
from bt_manip.cell import escaped_name, literal_name, name_elements
from bt_manip.cell.objects import correct_inertias, invented_masses, mjcf_root
from bt_manip.exceptions import BtManipError, did_you_mean, one_line
from bt_manip.models import ModelError, load_model, menagerie_file

from .convex_bodies import decompose_meshes
from .errors import RobotError
from .gripper_description import GripperDescription
from .locking import lock_other_joints
from .model_address import MENAGERIE
from .robot_description import RobotDescription

PEDESTAL = "pedestal"
"""Name of the body of the pedestal."""

_TOOL = "tool_frame"
_NAMED = {
    "actuator": mujoco.mjtObj.mjOBJ_ACTUATOR,
    "body": mujoco.mjtObj.mjOBJ_BODY,
    "joint": mujoco.mjtObj.mjOBJ_JOINT,
    "site": mujoco.mjtObj.mjOBJ_SITE,
    "tendon": mujoco.mjtObj.mjOBJ_TENDON,
}
_WORLD_SETTINGS = ("option", "visual", "statistic", "size", "keyframe")
_ROTATIONS = ("quat", "euler", "axisangle", "xyaxes", "zaxis")


class Assembly(NamedTuple):
    """A robot's model before it is attached to a world.

    Attributes:
        root: The model, as a PyMJCF element.
        alone: The same model, compiled on its own.
        gripper: The part of the model that contains the gripper's elements.
        tool_site: The site of the tool.
        warnings: What is strange in its files, or was lost in their conversion.
    """

    root: mjcf.RootElement
    alone: mujoco.MjModel
    gripper: mjcf.RootElement
    tool_site: Any
    warnings: tuple[str, ...]


def assemble(description: RobotDescription) -> Assembly:
    """Read the arm's model, attach the gripper's, and place both as described.

    Raises:
        RobotError: If a file is missing or invalid, or a name is unknown.
    """
    where = description.where
    warnings: list[str] = []
    root, alone = read_model(description.model, where, warnings.append)
    root.model = description.name
    joints = [_find(root, "joint", name) for name in description.arm_joints]
    if all(joint is not None for joint in joints) and lock_other_joints(root, joints):
        alone = _compile(root, where)
    gripper = description.gripper
    hand = root
    if gripper is not None and gripper.model is not None:
        hand, _ = read_model(gripper.model, where, warnings.append)
        _attach(root, alone, hand, gripper, where)
        alone = _compile(root, where)
    for name in description.convex_parts:
        try:
            decompose_meshes(_find_body(root, hand, name, where, "convex_parts"), alone)
        except ModelError as error:
            raise RobotError(f"{where}: key 'convex_parts': '{name}': {error}") from error
    if description.convex_parts:
        alone = _compile(root, where)
    if description.armature is not None:
        for joint, armature in zip(description.arm_joints, description.armature, strict=True):
            find_element(root, "joint", joint, where).armature = armature
        alone = _compile(root, where)
    tool = _tool_site(root, hand, alone, description, where)
    _move_base(root, alone, description.T_rb)
    _add_pedestal(root, description)
    for pair in description.exclude:
        first, second = (_find_body(root, hand, name, where) for name in pair)
        root.contact.add("exclude", body1=first, body2=second)
    return Assembly(root, alone, hand, tool, tuple(warnings))


def find_element(root: mjcf.RootElement, kind: str, name: str, where: str) -> Any:
    """Return a named element of a model.

    Raises:
        RobotError: If there is none of that name; the message suggests the nearest names.
    """
    element = _find(root, kind, name)
    if element is None:
        known = sorted(element_names(root, kind))
        raise RobotError(
            f"{where}: the model '{root.model}' has no {kind} '{name}'{did_you_mean(name, known)}"
        )
    return element


def _find(root: mjcf.RootElement, kind: str, name: str) -> Any:
    """Return the element with a name in its model file; None without one."""
    return root.find(kind, escaped_name(name))


def element_names(root: mjcf.RootElement, kind: str) -> list[str]:
    """Return the names of a model's elements of a kind, such as joints, as in its file."""
    found = (getattr(element, "name", None) for element in root.find_all(kind))
    return [literal_name(name) for name in found if name]


def read_model(
    model: str, where: str, warn: Callable[[str], None] = lambda warning: None
) -> tuple[mjcf.RootElement, mujoco.MjModel]:
    """Return the model of an arm or a gripper, as a PyMJCF element and compiled.

    Args:
        model: Path of an MJCF or URDF file, or ``menagerie:NAME/ENTRY``.
        where: The robot, to begin a message.
        warn: Takes what is strange in the file, or was lost in its conversion.

    Raises:
        RobotError: If the file is missing or invalid.
    """
    path = model_file(model, where)
    try:
        found = load_model(str(path))
        root = mjcf_root(found)
        if found.path is None:
            alone = mujoco.MjModel.from_xml_string(found.xml, dict(found.assets))
        elif found.xml:
            alone = _compile(root, where)
        else:
            alone = mujoco.MjModel.from_xml_path(str(path))
    except BtManipError as error:
        raise RobotError(f"{where}: {error}") from error
    except Exception as error:  # PyMJCF raises of everything
        raise RobotError(f"{where}: {path}: {one_line(error)}") from error
    fused = root.compiler.fusestatic == "true"
    if fused:  # bodies whose joints are locked keep their names
        root.compiler.fusestatic = "false"
    _drop_world(root)
    name_elements(root)
    if fused or any(
        element.name and mujoco.mj_name2id(alone, kind, element.name) < 0
        for name, kind in _NAMED.items()
        for element in root.find_all(name)
    ):
        alone = _compile(root, where)  # with the names that PyMJCF gives
    strange = list(correct_inertias(root, alone, tolerance=10.0))
    if strange:
        alone = _compile(root, where)
    strange += filter(None, [invented_masses(root, alone, fixed=True)])
    for warning in (*found.warnings, *(f"{path.name}: {text}" for text in strange)):
        warn(warning)
    return root, alone


def model_file(model: str, where: str) -> Path:
    """Return the file of a model: a path, or ``menagerie:NAME`` or ``menagerie:NAME/ENTRY``."""
    if not model.startswith(MENAGERIE):
        if not Path(model).is_file():
            raise RobotError(f"{where}: no model file {model}")
        return Path(model)
    try:
        return menagerie_file(model.removeprefix(MENAGERIE))
    except ModelError as error:
        raise RobotError(f"{where}: model '{model}': {error}") from error


def _compile(root: mjcf.RootElement, where: str) -> mujoco.MjModel:
    try:
        return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())
    except ValueError as error:
        raise RobotError(f"{where}: the model does not compile: {one_line(error)}") from error


def _attach(
    root: mjcf.RootElement,
    alone: mujoco.MjModel,
    hand: mjcf.RootElement,
    gripper: GripperDescription,
    where: str,
) -> None:
    """Attach the gripper's model at a site or body of the arm."""
    mount = gripper.mount or ""
    site = _find(root, "site", mount) or _find(root, "body", mount)
    T_mount = pin.SE3.Identity()
    if site is None:
        sites = [*element_names(root, "site"), *element_names(root, "body")]
        raise RobotError(
            f"{where}: a gripper of its own model is mounted at a site or body of the arm, "
            f"and there is no '{mount}'{did_you_mean(mount, sites)}"
        )
    if site.tag == "body":
        site = site.add("site", name="gripper_mount")
    else:
        T_mount = site_pose(alone, site)
    if hand.model == root.model:
        hand.model = f"{hand.model}_gripper"
    try:
        frame = site.attach(hand)
    except ValueError as error:
        raise RobotError(f"{where}: cannot attach the gripper: {one_line(error)}") from error
    _place(frame, T_mount * gripper.T_mg)


def _tool_site(
    root: mjcf.RootElement,
    hand: mjcf.RootElement,
    alone: mujoco.MjModel,
    description: RobotDescription,
    where: str,
) -> Any:
    """Return the tool's site; add one if the description offsets the tool or names a body."""
    name, kinds = description.tool_frame, ("site", "body")
    models = (hand,) if hand is root else (hand, root)
    elements = (_find(model, kind, name) for model in models for kind in kinds)
    found = next((element for element in elements if element is not None), None)
    if found is None:
        known = [name for model in models for kind in kinds for name in element_names(model, kind)]
        raise RobotError(
            f"{where}: {description.model} has no site or body '{name}'{did_you_mean(name, known)}"
        )
    body, T = found, description.T_ft
    if found.tag == "site":
        if T == pin.SE3.Identity():
            return found
        body, T = found.parent, site_pose(alone, found) * T
    tool = body.add("site", name=_TOOL, size=(0.002,), group=5)
    _place(tool, T)
    return tool


def _move_base(root: mjcf.RootElement, alone: mujoco.MjModel, T_rb: pin.SE3) -> None:
    """Transform the pose of every top-level body by `T_rb`."""
    if T_rb == pin.SE3.Identity():
        return
    for body in root.worldbody.body:
        compiled = alone.body(body.full_identifier)
        _place(body, T_rb * spatial.pose(compiled.pos, compiled.quat))


def _add_pedestal(root: mjcf.RootElement, description: RobotDescription) -> None:
    """Add a block under the base, as a body of its own: the arm can collide with it."""
    if description.pedestal is None:
        return
    half = [0.5 * size for size in description.pedestal]
    x, y, _ = description.T_rb.translation
    if root.find("body", PEDESTAL) is not None:
        raise RobotError(
            f"{description.where}: the model has a body '{PEDESTAL}' of its own, so the "
            "description cannot add one"
        )
    root.worldbody.add("body", name=PEDESTAL).add(
        "geom", name=PEDESTAL, type="box", size=half, pos=(x, y, half[2]), mass=0.0,
        rgba=(0.35, 0.36, 0.38, 1.0),
    )  # fmt: skip


def _find_body(
    root: mjcf.RootElement, hand: mjcf.RootElement, name: str, where: str, key: str = "exclude"
) -> Any:
    """Return a body of the arm, or of the gripper: by its name or ``MODEL/NAME``."""
    body = _find(root, "body", name) or _find(hand, "body", name.removeprefix(f"{hand.model}/"))
    if body is None:
        known = [*element_names(root, "body"), *element_names(hand, "body")]
        raise RobotError(
            f"{where}: {key}: there is no body '{name}'{did_you_mean(name, set(known))}"
        )
    return body


def site_pose(alone: mujoco.MjModel, site: Any) -> pin.SE3:
    """Return the pose of a site in its body; an added site is not in the compiled model."""
    name = site.full_identifier
    compiled = mujoco.mj_name2id(alone, int(_NAMED["site"]), name) >= 0
    found = alone.site(name) if compiled else site
    return spatial.pose(found.pos, found.quat)


def _place(element: Any, T: pin.SE3) -> None:
    for attribute in _ROTATIONS:
        if getattr(element, attribute, None) is not None:
            delattr(element, attribute)
    element.pos = T.translation
    element.quat = spatial.quat_wxyz(T)


def _drop_world(root: mjcf.RootElement) -> None:
    """Remove world settings, a floor, and gravity compensation, the controller's task."""
    for setting in _WORLD_SETTINGS:
        getattr(root, setting).remove()
    for geom in root.worldbody.find_all("geom", immediate_children_only=True):
        if geom.type == "plane":
            geom.remove()
    for light in list(root.find_all("light")):
        light.remove()
    for body in root.find_all("body"):
        if body.gravcomp is not None:
            del body.gravcomp
