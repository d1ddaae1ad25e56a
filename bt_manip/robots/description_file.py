"""Reading of a robot's description from a TOML file."""

from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import pinocchio as pin

from bt_manip.toml_tables import TomlFile, TomlTable

from .assembly import MENAGERIE
from .configurations import read_configurations
from .errors import RobotError
from .gripper import DEFAULT_KIND, GripperDescription
from .robot_description import RobotDescription, Tolerance, ToolLimits

_Numbers = TypeVar("_Numbers", Tolerance, ToolLimits)


def read_description(path: Path | str) -> RobotDescription:
    """Read a robot's description.

    The keys are those of `RobotDescription`, with the poses in tables: ``[base]`` has the pose of
    the base in a scene, ``[tool]`` the ``frame`` and the pose of the tool in it, and ``[gripper]``
    the gripper, with the keys of its ``kind``. A single number applies to every joint.

    Args:
        path: The file; model paths in it are relative to its folder.

    Raises:
        RobotError: If the file is missing, or keys are missing or wrong; the message has a line for
            each of these, with the file and the key.
    """
    path = Path(path)
    table = _file(path).whole
    arm_joints = table.texts("arm_joints")
    if len(set(arm_joints)) < len(arm_joints):
        table.reject("arm_joints", f"names each joint once, got {', '.join(arm_joints)}")
    n = len(arm_joints) or None
    base, tool = table.table("base"), table.table("tool")
    if tool is None:
        table.reject("tool", "is missing: a table with the 'frame' that poses are asked for")
    given: dict[str, Any] = dict(
        name=table.text("name") or path.stem,
        model=_model(table.needed_text("model"), path),
        arm_joints=arm_joints,
        tool_frame="" if tool is None else tool.needed_text("frame"),
        T_ft=pin.SE3.Identity() if tool is None else tool.pose(),
        T_rb=pin.SE3.Identity() if base is None else base.pose(),
        pedestal=None if base is None else base.numbers("pedestal", 3, above=0.0),
        home=table.needed_numbers("home", n),
        velocity=table.needed_numbers("velocity", n, above=0.0),
        acceleration=table.needed_numbers("acceleration", n, above=0.0),
        jerk=table.needed_numbers("jerk", n, above=0.0),
        effort=table.numbers("effort", n, spread=True, above=0.0),
        armature=table.numbers("armature", n, spread=True, at_least=0.0),
        gripper=_gripper(table.table("gripper"), path),
        tool_limits=_positive_numbers(table.table("tool_limits"), ToolLimits),
        tolerance=_positive_numbers(table.table("tolerance"), Tolerance),
        exclude=table.name_pairs("exclude"),
        configurations=read_configurations(table, path.parent),
        source=str(path),
    )
    for part in (tool, base, table):
        if part is not None:
            part.finish()
    return RobotDescription(**given)


def read_gripper(path: Path | str) -> GripperDescription | None:
    """Read only the gripper of a robot's description, whatever is wrong with the rest.

    Raises:
        RobotError: If keys of the gripper that all kinds have are missing or wrong.
    """
    file = _file(Path(path))
    gripper = _gripper(file.whole.table("gripper"), file.path)
    if file.problems:
        raise RobotError("\n".join(map(str, file.problems)))
    return gripper


def _file(path: Path) -> TomlFile:
    return TomlFile(path, "robot description", RobotError, collects=True)


def _model(text: str, path: Path) -> str:
    return text if text.startswith(MENAGERIE) else str(path.parent / text)


def _gripper(table: TomlTable | None, path: Path) -> GripperDescription | None:
    if table is None:
        return None
    model = table.text("model")
    gripper = GripperDescription(
        max_force=table.number("max_force", above=0.0),
        kind=table.text("kind") or DEFAULT_KIND,
        model=None if model is None else _model(model, path),
        mount=table.needed_text("mount") if model else None,
        T_mg=table.pose(),
        file=table.file,
    )
    return replace(gripper, parameters=table.rest())


def _positive_numbers(table: TomlTable | None, kind: type[_Numbers]) -> _Numbers:
    """Return a dataclass of positive numbers; keys that are missing keep its defaults."""
    if table is None:
        return kind()
    given = {key: table.number(key, above=0.0) for key in get_type_hints(kind)}
    table.finish()
    return kind(**{key: value for key, value in given.items() if value is not None})
