"""The gripper's part of a robot's description."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import pinocchio as pin

from bt_manip.toml import (
    Key,
    KeyField,
    OtherKeys,
    PythonSource,
    TomlFile,
    TomlTable,
    documented,
    entries_of,
    read_fields,
    write_fields,
)

from .errors import RobotError
from .model_address import ModelAddress

DEFAULT_KIND = "two_finger"
"""Kind of gripper if the description names none."""


@documented
@dataclass(frozen=True)
class GripperDescription:
    """Description of a gripper: its kind, common data, and parameters of the kind.

    The field `file`, not a key, is the file that contains the parameters, for messages.
    """

    kind: Annotated[str, Key("Registered name of the kind of gripper")] = DEFAULT_KIND
    max_force: Annotated[
        float | None,
        Key("Maximum grip force; left out where parameters of the kind imply it", "N", above=0.0),
    ] = None
    model: Annotated[
        str | None,
        Key("Its file of MJCF or URDF; left out if it is part of the arm's", values=ModelAddress()),
    ] = None
    mount: Annotated[
        str | None, Key("The arm's site or body to which a separate model is attached")
    ] = None
    T_mg: Annotated[pin.SE3, Key("Pose of that model in the mount", "m, rad")] = field(
        default_factory=pin.SE3.Identity
    )
    parameters: Annotated[
        Mapping[str, Any],
        Key(
            "Parameters of the kind, as plain data; `read` gives a table",
            values=OtherKeys("keys of the kind"),
        ),
    ] = field(default_factory=dict)
    file: TomlFile | PythonSource | None = field(default=None, compare=False, repr=False)

    def read(self, robot: str) -> TomlTable:
        """Return the parameters as a table; the kind calls ``finish`` to reject unknown keys.

        Args:
            robot: Name of the robot, for messages.
        """
        source = self.file or PythonSource(f"robot '{robot}'", RobotError)
        table = TomlTable(source, self.parameters, ("gripper",))
        for entry in entries_of(type(self)):  # known, to be suggested for mistyped keys
            if not isinstance(entry.values, OtherKeys):
                entry.values.read(table, entry, None)
        return table


class GripperTable:
    """The table of a gripper's description; one with a model of its own needs a mount."""

    type, cls = "a table", GripperDescription

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> GripperDescription | None:
        """Return the description."""
        return self.read_table(table.table(entry.name))

    def read_table(self, table: TomlTable | None) -> GripperDescription | None:
        """Return the description in ``[gripper]``."""
        if table is None:
            return None
        given = read_fields(GripperDescription, table)
        if "model" in given:
            table.require("mount", "a text")
        return GripperDescription(**given, file=table.file)

    def write(
        self, value: GripperDescription, entry: KeyField, folder: Path | None
    ) -> dict[str, Any]:
        """Return the table."""
        return {entry.name: write_fields(value, folder)}
