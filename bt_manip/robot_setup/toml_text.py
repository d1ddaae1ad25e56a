"""Writing of a robot's description as TOML."""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pinocchio as pin

from bt_manip import spatial
from bt_manip.robots import MENAGERIE, GripperDescription, RobotDescription, Tolerance, ToolLimits

_WIDTH = 100  # columns, at most
_DIGITS = 6  # after the point: micrometres and microradians


def description_text(
    description: RobotDescription, notes: Mapping[str, str], folder: Path, head: str
) -> str:
    """Return a description as TOML that `bt_manip.robots.read_description` reads.

    Args:
        description: The description.
        notes: Comments by key, such as ``"velocity"`` and ``"gripper.max_force"``.
        folder: Folder of the file, to which paths of models are relative.
        head: Comment at the beginning.
    """
    one = description
    lines = [*_comment(head), "", *_model(one.model, folder, notes, "model")]
    for key in ("arm_joints", "home", "velocity", "acceleration", "jerk", "effort"):
        lines += _entry(key, getattr(one, key), notes)
    lines += _entry("exclude", one.exclude or None, notes)
    base: dict[str, Any] = _pose(one.T_rb) | ({"pedestal": one.pedestal} if one.pedestal else {})
    lines += _table("base", base, notes)
    lines += _table("tool", {"frame": one.tool_frame, **_pose(one.T_ft)}, notes)
    for name, default in (("tool_limits", ToolLimits()), ("tolerance", Tolerance())):
        given = vars(getattr(one, name))
        changed = {k: v for k, v in given.items() if v != getattr(default, k)}
        lines += _table(name, changed, notes)
    lines += _gripper(one.gripper, folder, notes)
    return "\n".join([*lines, ""])


def _gripper(
    gripper: GripperDescription | None, folder: Path, notes: Mapping[str, str]
) -> list[str]:
    if gripper is None:
        return []
    lines = ["", *_comment(notes.get("gripper", "")), "[gripper]"]
    lines += _entry("kind", gripper.kind, notes, "gripper.")
    if gripper.model is not None:
        lines += _model(gripper.model, folder, notes, "gripper.model")
        entries = {"mount": gripper.mount, **_pose(gripper.T_mg)}
        for key, value in entries.items():
            lines += _entry(key, value, notes, "gripper.")
    tables = {k: v for k, v in gripper.parameters.items() if isinstance(v, Mapping)}
    for key, value in gripper.parameters.items():
        lines += _entry(key, None if key in tables else value, notes, "gripper.")
    lines += _entry("max_force", gripper.max_force, notes, "gripper.")
    for key, value in tables.items():
        lines += _table(f"gripper.{key}", value, notes)
    return lines


def _model(model: str, folder: Path, notes: Mapping[str, str], key: str) -> list[str]:
    if not model.startswith(MENAGERIE):
        model = Path(os.path.relpath(model, folder)).as_posix()
    return [*_comment(notes.get(key, "")), f"model = {_value(model)}"]


def _table(name: str, entries: Mapping[str, Any], notes: Mapping[str, str]) -> list[str]:
    if not entries:
        return []
    lines = ["", *_comment(notes.get(name, "")), f"[{name}]"]
    for key, value in entries.items():
        lines += _entry(key, value, notes, f"{name}.")
    return lines


def _entry(key: str, value: Any, notes: Mapping[str, str], table: str = "") -> list[str]:
    if value is None:
        return []
    return [*_comment(notes.get(table + key, "")), *_assigned(key, value)]


def _assigned(key: str, value: Any) -> Iterable[str]:
    """Yield the lines of a key; long lists are broken."""
    text = f"{key} = {_value(value)}"
    if len(text) <= _WIDTH or not isinstance(value, Sequence):
        return [text]
    lines = [""]
    for item in value:
        part = f"{_value(item)}, "
        if len(lines[-1]) + len(part) > _WIDTH - 4:
            lines.append("")
        lines[-1] += part
    return [f"{key} = [", *(f"    {line.rstrip()}" for line in lines), "]"]


def _comment(text: str) -> list[str]:
    return [f"# {line}".rstrip() for line in text.splitlines()]


def _pose(T: pin.SE3) -> dict[str, Any]:
    """Return the keys of a pose that differ from those of the identity."""
    found: dict[str, Any] = {}
    if T.translation.any():
        found["position"] = T.translation.tolist()
    if not (T.rotation == pin.SE3.Identity().rotation).all():
        found["quat_wxyz"] = spatial.quat_wxyz(T).tolist()
    return found


def _value(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(round(value, _DIGITS) + 0.0)
    if isinstance(value, Sequence):
        return f"[{', '.join(_value(item) for item in value)}]"
    return str(value)
