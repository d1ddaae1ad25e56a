"""A robot's description from a TOML file."""

from dataclasses import fields
from pathlib import Path

import pinocchio as pin

from bt_manip.toml_tables import TomlFile, TomlTable

from .errors import RobotError
from .model_files import MENAGERIE
from .robot_description import GripperDescription, PadDescription, RobotDescription, ToolLimits


def read_description(path: Path | str) -> RobotDescription:
    """Read a robot's description.

    The keys are those of `RobotDescription`, with the poses in tables: ``[base]`` says where the
    robot stands in a scene, ``[tool]`` has the ``frame`` and the pose of the tool in it, and
    ``[gripper]`` with ``[gripper.pads]`` the gripper. One number stands for one of every joint.

    Args:
        path: The file; paths of models in it start from its folder.

    Raises:
        RobotError: With the file and the key, when it is missing or wrong.
    """
    path = Path(path)
    table = TomlFile(path, "robot description", RobotError).whole
    arm_joints = table.texts("arm_joints")
    n = len(arm_joints)
    base, tool = table.table("base"), table.table("tool")
    if tool is None:
        raise table.error("tool", "is missing: a table with the 'frame' that poses are asked for")
    description = RobotDescription(
        name=table.text("name") or path.stem,
        model=_model(table.needed_text("model"), path),
        arm_joints=arm_joints,
        tool_frame=tool.needed_text("frame"),
        T_ft=tool.pose(),
        T_rb=pin.SE3.Identity() if base is None else base.pose(),
        pedestal=None if base is None else _pedestal(base),
        home=table.needed_numbers("home", n),
        velocity=table.needed_numbers("velocity", n),
        acceleration=table.needed_numbers("acceleration", n),
        jerk=table.needed_numbers("jerk", n),
        effort=table.numbers("effort", n, spread=True),
        gripper=_gripper(table.table("gripper"), path),
        tool_limits=_tool_limits(table.table("tool_limits")),
    )
    for part in (tool, base, table):
        if part is not None:
            part.finish()
    return description


def _pedestal(base: TomlTable) -> tuple[float, float, float] | None:
    size = base.numbers("pedestal", 3)
    return None if size is None else (size[0], size[1], size[2])


def _model(text: str, path: Path) -> str:
    return text if text.startswith(MENAGERIE) else str(path.parent / text)


def _gripper(table: TomlTable | None, path: Path) -> GripperDescription | None:
    if table is None:
        return None
    joints, fingers = table.texts("joints"), table.texts("fingers")
    for key, names in (("joints", joints), ("fingers", fingers)):
        if len(names) != 2:
            raise table.error(key, f"names two, one a finger, got {len(names)}")
    model = table.text("model")
    gripper = GripperDescription(
        joints=joints,
        fingers=fingers,
        open_width=table.needed_number("open_width"),
        max_speed=table.needed_number("max_speed"),
        max_force=table.needed_number("max_force"),
        min_width=table.number("min_width", 0.0) or 0.0,
        motor=table.text("motor"),
        model=None if model is None else _model(model, path),
        mount=table.needed_text("mount") if model else None,
        T_mg=table.pose(),
        pads=_pads(table.table("pads")),
        armature=table.number("armature"),
        frictionloss=table.number("frictionloss"),
    )
    table.finish()
    return gripper


def _pads(table: TomlTable | None) -> PadDescription | None:
    if table is None:
        return None
    given = {f.name: table.numbers(f.name) for f in fields(PadDescription)}
    pads = PadDescription(**{key: value for key, value in given.items() if value is not None})
    table.finish()
    return pads


def _tool_limits(table: TomlTable | None) -> ToolLimits:
    if table is None:
        return ToolLimits()
    given = {f.name: table.number(f.name) for f in fields(ToolLimits)}
    limits = ToolLimits(**{key: value for key, value in given.items() if value is not None})
    table.finish()
    return limits
