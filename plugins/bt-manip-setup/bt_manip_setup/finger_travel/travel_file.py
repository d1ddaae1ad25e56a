"""Writing of the measured travel into the file of a robot's description."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bt_manip.robots import RobotDescription, RobotError
from bt_manip.toml import toml_text

from .measurement import measured

TRAVEL_NOTE = "Measured by bt-manip robot measure; the digests are of what it depends on."
"""Comment on the table ``[gripper.travel]``."""

_OWN = re.compile(r"\s*\[\s*gripper\s*\.\s*travel\s*[.\]]")
_HEADER = re.compile(r"\s*\[{1,2}\s*[A-Za-z_\"'][^,]*\]{1,2}\s*(#.*)?$")


def write_travel(description: RobotDescription) -> tuple[Path, Mapping[str, Any]]:
    """Measure the travel of a gripper's fingers and write it into the description's file.

    The file is that of the key ``gripper.travel``, where it has a path, or that of the description,
    of which all other lines are kept.

    Args:
        description: The robot's description, with any or no travel.

    Returns:
        The file, and the travel as plain data.

    Raises:
        RobotError: If the gripper has no two fingers, the model does not fit the description, or
            the description has no file that can be written.
    """
    described = measured(description).gripper
    assert description.gripper is not None and described is not None
    travel, given = described.parameters["travel"], description.gripper.parameters.get("travel")
    if not isinstance(given, str) and not description.source:
        raise RobotError(
            f"{description.where} is described in Python: give its gripper the path of a file to "
            "write to, such as travel=str(Path(__file__).parent / 'travel.toml')"
        )
    path = Path(description.source)
    try:
        if isinstance(given, str):
            path = path.parent / given if description.source else Path(given)
            text = toml_text(travel, {}, f"Fingers of {description.name}. {TRAVEL_NOTE}")
        else:
            text = _with_travel(path, path.read_text(encoding="utf-8"), travel)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RobotError(f"cannot write {path}: {error.strerror}") from error
    return path, travel


def _with_travel(path: Path, text: str, travel: Mapping[str, Any]) -> str:
    """Return the text of a description with its table ``[gripper.travel]`` replaced or appended."""
    kept: list[str] = []
    own = False
    for line in text.splitlines():
        if _OWN.match(line):
            own = True
            if kept and TRAVEL_NOTE in kept[-1]:
                kept.pop()
        elif own and _HEADER.match(line):
            own = False
            kept.append("")
        if not own:
            kept.append(line)
    table = toml_text({"gripper": {"travel": travel}}, {"gripper.travel": TRAVEL_NOTE}, "")
    written = "\n".join(kept).rstrip() + f"\n{table}"
    try:
        before, after = tomllib.loads(text), tomllib.loads(written)
        before["gripper"].pop("travel", None)
        complete = after["gripper"].pop("travel") == travel and before == after
    except ValueError:
        complete = False
    if not complete:
        raise RobotError(
            f"{path}: cannot write key 'gripper.travel': give [gripper] and [gripper.travel] as "
            "tables with a header"
        )
    return written
