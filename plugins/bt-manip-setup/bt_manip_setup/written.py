"""Descriptions of robots as text."""

from collections.abc import Mapping
from pathlib import Path

from bt_manip.robots import RobotDescription
from bt_manip.toml import toml_text, write_fields


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
