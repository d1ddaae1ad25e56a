"""Travel of the fingers of a gripper as a function of its joints, measured once for a model."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.polynomial import Polynomial

from bt_manip.robots import RobotError
from bt_manip.toml import (
    Key,
    KeyField,
    TomlFile,
    TomlTable,
    documented,
    plain,
    read_part,
    write_fields,
)

_MARGIN = 1.2  # factor on the motors' efforts, for friction

Rows = tuple[tuple[float, ...], ...]


class NumberRows:
    """Lists of numbers in a list."""

    type = "a list of lists of numbers"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Rows | None:
        """Return the lists."""
        value = table.value(entry.name)
        if isinstance(value, list) and all(isinstance(row, list) and row for row in value):
            if all(isinstance(x, int | float) for row in value for x in row):
                return tuple(tuple(map(float, row)) for row in value)
        table.reject(entry.name, f"is {self.type}")
        return None

    def write(self, value: Rows, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        """Return the key."""
        return {entry.name: plain(value)}


class DigestTable:
    """A table of digests by the name of a part."""

    type = "a table of texts"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> dict[str, str] | None:
        """Return the digests."""
        part = table.table(entry.name)
        return None if part is None else {key: part.needed_text(key) for key in part.keys()}

    def write(self, value: Mapping[str, str], entry: KeyField, folder: Path | None) -> Any:
        """Return the table."""
        return {entry.name: dict(value)}


@documented
@dataclass(frozen=True, kw_only=True)
class FingerTravel:
    """Travel of two fingers as a function of their joints.

    The opening is the distance between the parts of the fingers from the tool centre point to the
    tips, along their relative motion. Each finger has a distance s from the centre; the opening is
    the sum of both. With one motor, each s is half the opening, even if only one finger moves. By
    the principle of virtual work, a force of 1 N at the finger requires an effort of ds/dq at the
    joint.
    """

    motor: Annotated[
        str | None,
        Key("Joint or tendon moved by the motor for both fingers; left out for a motor each"),
    ] = None
    open_width: Annotated[float, Key("Maximum opening", "m")]
    min_width: Annotated[float, Key("Minimum opening", "m")]
    polynomials: Annotated[
        Rows, Key("Coefficients of s(q) for each finger, the constant first", values=NumberRows())
    ]
    holding: Annotated[
        Rows,
        Key(
            "Coefficients of each motor's effort against springs as a function of q",
            values=NumberRows(),
        ),
    ]
    ratios: Annotated[
        tuple[float, ...],
        Key("Velocity of each finger's joint per velocity of the motor", size=2),
    ]
    mass: Annotated[
        float, Key("Effective mass of one finger along s; 0: that of the joint in the model", "kg")
    ]
    loss: Annotated[float, Key("Viscous friction of one finger, along s", "N s/m")]
    friction: Annotated[float, Key("Dry friction of one finger, along s", "N")]
    closing: Annotated[
        tuple[float, ...],
        Key("Direction from the second to the first finger in the tool frame; unit", size=3),
    ]
    centre: Annotated[
        tuple[float, ...],
        Key(
            "Coordinate along `closing` of the midpoint between the fingers in the tool frame, at "
            "zero opening [m], and its change per opening: 0.5 if the second finger is fixed",
            size=2,
        ),
    ]
    joints: Annotated[tuple[str, ...], Key("Names of all joints that move with the fingers")]
    widths: Annotated[
        tuple[float, ...], Key("Openings at which `positions` were measured, increasing", "m")
    ]
    positions: Annotated[
        Rows, Key("Positions of each of `joints` at the `widths`", "m, rad", values=NumberRows())
    ]
    digests: Annotated[
        Mapping[str, str],
        Key("Digests of the parts of the model that were measured", values=DigestTable()),
    ]

    @property
    def one_moves(self) -> bool:
        """Whether the second finger is fixed."""
        return self.centre[1] != 0.0

    @cached_property
    def _positions(self) -> np.ndarray:
        return np.array(self.positions)

    def configuration(self, width: float) -> np.ndarray:
        """Return the positions of all moving joints at an opening [m]."""  # (len(joints),)
        return np.array([np.interp(width, self.widths, row) for row in self._positions])

    def efforts(self, force: float, joints: tuple[str, ...]) -> list[float]:
        """Return the maximum effort of each motor for a finger force, plus 20 % for friction.

        Args:
            force: Force of each finger [N].
            joints: The joints that the fingers follow: one for each, or one for both.
        """
        efforts, springs = [], []
        rows = [self._positions[self.joints.index(name)] for name in (joints[0], joints[-1])]
        for polynomial, holding, ratio, q in zip(
            self.polynomials, self.holding, self.ratios, rows, strict=True
        ):
            slope = Polynomial(polynomial).deriv()(q)
            efforts.append(_MARGIN * force * float(np.abs(slope * ratio).max()))
            springs.append(float(np.abs(Polynomial(holding)(q)).max()))
        if self.motor is not None:
            return [sum(efforts) + springs[0]]
        return [effort + spring for effort, spring in zip(efforts, springs, strict=True)]


class TravelTable:
    """A measured travel: a table, or the path of a TOML file that contains it."""

    type = "a table that `bt-manip robot measure` writes, or the path of its file"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> FingerTravel | None:
        """Return the travel; None if it is missing."""
        value = table.value(entry.name)
        if not isinstance(value, str):
            part = table.table(entry.name)
        else:
            file = table.file
            path = (file.path.parent if isinstance(file, TomlFile) else Path()) / value
            if not path.is_file():
                return None
            part = TomlFile(path, "finger travel", RobotError).whole
        travel = None if part is None else read_part(FingerTravel, part)
        if travel is not None:
            shape = {len(travel.widths)}, len(travel.joints)
            if ({*map(len, travel.positions)}, len(travel.positions)) != shape:
                table.reject(entry.name, "has 'positions' that do not fit 'joints' and 'widths'")
        return travel

    def write(self, value: FingerTravel, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        """Return the table."""
        return {entry.name: write_fields(value)}
