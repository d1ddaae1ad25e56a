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
    keys = ("arm_joints", "home", "velocity", "acceleration", "jerk", "effort")
    tables: dict[str, Mapping[str, Any]] = {
        "": {
            "model": _address(one.model, folder),
            **{key: getattr(one, key) for key in keys},
            "exclude": one.exclude or None,
        },
        "base": _pose(one.T_rb) | ({"pedestal": one.pedestal} if one.pedestal else {}),
        "tool": {"frame": one.tool_frame, **_pose(one.T_ft)},
    }
    for name, default in (("tool_limits", ToolLimits()), ("tolerance", Tolerance())):
        given = vars(getattr(one, name))
        tables[name] = {k: v for k, v in given.items() if v != getattr(default, k)}
    if one.gripper is not None:
        tables |= _gripper(one.gripper, folder)
    lines = _comment(head)
    for name, entries in tables.items():
        lines += _table(name, entries, notes)
    return "\n".join([*lines, ""])


def _gripper(gripper: GripperDescription, folder: Path) -> dict[str, Mapping[str, Any]]:
    """Return the entries of the tables of a gripper."""
    entries: dict[str, Any] = {"kind": gripper.kind}
    if gripper.model is not None:
        entries |= {"model": _address(gripper.model, folder), "mount": gripper.mount}
        entries |= _pose(gripper.T_mg)
    given = gripper.parameters
    tables = {f"gripper.{k}": v for k, v in given.items() if isinstance(v, Mapping)}
    entries |= {k: v for k, v in given.items() if not isinstance(v, Mapping)}
    return {"gripper": entries | {"max_force": gripper.max_force}, **tables}


def _address(model: str, folder: Path) -> str:
    return model if model.startswith(MENAGERIE) else Path(os.path.relpath(model, folder)).as_posix()


def _table(name: str, entries: Mapping[str, Any], notes: Mapping[str, str]) -> list[str]:
    """Return the lines of a table, after an empty one; the root table has an empty name."""
    lines = ["", *_comment(notes.get(name, "")), f"[{name}]"] if name else [""]
    prefix = f"{name}." if name else ""
    for key, value in entries.items():
        if value is not None:
            lines += [*_comment(notes.get(prefix + key, "")), *_assigned(key, value)]
    return lines if entries else []


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
