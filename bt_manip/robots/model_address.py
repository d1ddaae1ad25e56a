"""Addresses of model files in descriptions."""

import os
from pathlib import Path
from typing import Any

from bt_manip.toml import KeyField, TomlFile, TomlTable

MENAGERIE = "menagerie:"
"""Prefix of addresses of MuJoCo Menagerie models."""


class ModelAddress:
    """A path of MJCF or URDF, relative to the file that names it, or ``menagerie:NAME/ENTRY``."""

    type = "a path from the folder of the file, or `menagerie:NAME/ENTRY`"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> str | None:
        """Return the address, with the folder of the file."""
        text = table.text(entry.name)
        if text is None or text.startswith(MENAGERIE) or not isinstance(table.file, TomlFile):
            return text
        return str(table.file.path.parent / text)

    def write(self, value: str, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        """Return the key, relative to a folder."""
        if folder is None or value.startswith(MENAGERIE):
            return {entry.name: value}
        return {entry.name: Path(os.path.relpath(value, folder)).as_posix()}
