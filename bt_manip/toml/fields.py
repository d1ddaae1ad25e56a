"""Keys of TOML files, declared as fields of dataclasses.

``velocity: Annotated[tuple[float, ...], Key("Velocity limits.", unit="rad/s", above=0.0)]`` is read
by `read_fields`, written by `write_fields`, checked by `check_fields`, and listed in the docstring
(`documented`) and in the documentation.
"""

import re
import types
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache
from math import inf
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeVar, Union, get_args, get_origin
from typing import get_type_hints as hints_of

import pinocchio as pin

from bt_manip import spatial
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import Parameter

from .tables import PythonSource, TomlTable

T = TypeVar("T")

_DIGITS = 12  # decimals of positions and quaternions, as rotation matrices round


@dataclass(frozen=True, eq=False)
class Key(Parameter):
    """Declaration of a dataclass field as a key of a TOML file.

    Attributes:
        size: Number of its values, a minimum and a maximum, or the field with as many names; with
            the latter, a single number applies to all.
        table: Table that contains it; empty for the table of its dataclass.
        name: Its name in the file; empty for that of the field.
        needed: Whether it is required; by default if the field has no default value.
        values: An object for a type other than the built-in ones: its `type` in words; its method
            ``read(table, entry, size)`` returns the value, or None if it is missing or rejected;
            where it is written, ``write(value, entry, folder)`` returns its entries.
        attribute: Name of the field; of keys of `entries_of`, like default, name and values.
    """

    table: str = ""
    needed: bool | None = None
    values: Any = None
    attribute: str = ""

    def __post_init__(self) -> None:
        """Leave type and size to the field."""

    @property
    def form(self) -> str:
        """The type, for users."""
        if isinstance(self.size, str):
            return f"number, or one for each of `{self.size}`"
        name = self.values.type.removeprefix("a list of ").removeprefix("a ")
        count = " to ".join(map(str, self.size)) if isinstance(self.size, tuple) else self.size
        return name if count is None else f"{count} {name}"

    @property
    def wanted(self) -> str:
        """The type, for the message that the key is missing."""
        sized = isinstance(self.size, int) and self.unit
        return f"{self.form} [{self.unit}]" if sized else self.values.type

    @property
    def names(self) -> tuple[str, ...]:
        """All keys of the field in its table."""
        return tuple(re.split(", | or ", getattr(self.values, "names", self.name)))


KeyField = Key
"""A key as `entries_of` returns it, with the field that declares it."""


def entries_of(cls: Any) -> tuple[KeyField, ...]:
    """Return the declared keys of a dataclass, in the order of its fields."""
    return _entries_of(cls)


@cache
def _entries_of(cls: Any) -> tuple[KeyField, ...]:
    hints = hints_of(cls, include_extras=True)
    found = []
    for field in fields(cls):
        hint = hints[field.name]
        key = next((k for k in getattr(hint, "__metadata__", ()) if isinstance(k, Key)), None)
        if key is None:
            continue
        make = field.default_factory
        default = field.default if make is MISSING else make()
        needed = default is MISSING if key.needed is None else key.needed
        values = key.values or _values_of(get_args(hint)[0])
        name = key.name or field.name
        found.append(
            replace(
                key, name=name, default=default, needed=needed, values=values, attribute=field.name
            )
        )
    return tuple(found)


def read_fields(cls: type, table: TomlTable) -> dict[str, Any]:
    """Return the values of a dataclass's fields present in a table; reject wrong keys."""
    given: dict[str, Any] = {}
    tables: dict[str, TomlTable | None] = {}
    for entry in sorted(entries_of(cls), key=lambda entry: isinstance(entry.values, OtherKeys)):
        name = entry.table
        if name and name not in tables:
            tables[name] = table.table(name)
        part = tables[name] if name else table
        if part is None:
            if entry.needed:
                table.reject(name, f"is missing: a table with the '{entry.name}'")
            continue
        if entry.needed and not part.require(entry.name, entry.wanted):
            continue
        size = entry.size
        value = entry.values.read(part, entry, given.get(size) if isinstance(size, str) else size)
        if value is not None:
            given[entry.attribute] = value
    for part in (*tables.values(), table):
        if part is not None:
            part.finish()
    return given


def read_part(cls: type[T], table: TomlTable, **defaults: Any) -> T | None:
    """Return a dataclass read from a table; None if required keys are rejected.

    Args:
        cls: The dataclass.
        table: The table.
        **defaults: Values of fields without a key, in place of the dataclass's defaults.
    """
    given = defaults | read_fields(cls, table)
    needed = {f.name for f in fields(cls) if f.default is f.default_factory is MISSING}  # type: ignore[arg-type]
    return cls(**given) if needed <= given.keys() else None


def write_fields(value: Any, folder: Path | None = None) -> dict[str, Any]:
    """Return the keys of a dataclass that differ from their defaults, as plain data by table.

    Args:
        value: The dataclass.
        folder: Folder of the file, to which paths are made relative; None keeps paths.

    Raises:
        TypeError: If a value is of another type than its key, with the key.
    """
    found: dict[str, Any] = {}
    for entry in entries_of(type(value)):
        given = getattr(value, entry.attribute)
        default = entry.default
        if given is None or (default is not MISSING and given == default):
            continue
        try:
            written = entry.values.write(given, entry, folder)
        except (AttributeError, TypeError, ValueError):
            what = f"key '{entry.name}' is {entry.values.type}, got {given!r}"
            raise TypeError(what) from None
        (found.setdefault(entry.table, {}) if entry.table else found).update(written)
    return found


def check_fields(value: Any, where: str, error: type[BtManipError]) -> None:
    """Check a dataclass created in Python as if it were read from a file.

    Raises:
        BtManipError: Of the type `error`, with the name `where` and the key.
    """
    try:
        written = write_fields(value)
    except TypeError as problem:
        raise error(f"{where}: {problem}") from None
    read_fields(type(value), TomlTable(PythonSource(where, error), written))


def documented(cls: type[T]) -> type[T]:
    """Add the declared keys of a dataclass to its docstring, as the section of attributes."""
    lines = [(cls.__doc__ or "").rstrip(), "", "    Attributes:"]
    for entry in entries_of(cls):
        lines.append(f"        {entry.attribute}: {entry.described.removesuffix('.')}.")
    cls.__doc__ = "\n".join([*lines, "    "])
    return cls


class _Simple(NamedTuple):
    """Values read by a method of `TomlTable`."""

    type: str
    method: str

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        if entry.name not in table.keys():
            table.value(entry.name)  # so that it is known
            return None
        return getattr(table, self.method)(entry.name)

    def write(self, value: Any, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        return {entry.name: plain(value)}


class _Number(_Simple):
    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        return getattr(table, self.method)(entry.name, bounds=entry)


class _Numbers(_Simple):
    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        spread = isinstance(entry.size, str)
        if spread:
            size = len(size) if size else None
        least, most = size if isinstance(size, tuple) else (size, size)
        found = table.numbers(
            entry.name, least if least == most else None, spread=spread, bounds=entry
        )
        if found is not None and least != most and not least <= len(found) <= most:
            table.reject(entry.name, f"is a list of {least} to {most} numbers")
        return found

    def write(self, value: Any, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        return {entry.name: [float(number) for number in value]}


class _Names(_Simple):
    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        if super().read(table, entry, size) is None:
            return None
        names, shown = table.texts(entry.name), ", ".join(table.texts(entry.name))
        least, most = size if isinstance(size, tuple) else (size or 1, size or inf)
        if len(set(names)) < len(names) or not least <= len(names) <= most:
            numbers = f"{least} names" if least == most else f"{least} to {most} names"
            count = "at least one name" if most == inf else numbers
            table.reject(entry.name, f"is a list of {count}, each once, got {shown or 'none'}")
        return names


class _Pairs(_Simple):
    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        pairs = table.name_pairs(entry.name)
        for pair in pairs:
            if pair[0] == pair[1]:
                table.reject(entry.name, f"has pairs of two names, got '{pair[0]}' twice")
        return pairs


class _Pose(NamedTuple):
    """A pose, in three keys of its table."""

    type: str = "a pose"
    names: str = "position, quat_wxyz or rpy"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        return table.pose()

    def write(self, value: Any, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        return pose_entries(value)


class Part(NamedTuple):
    """A dataclass in its own table."""

    cls: type[Any]
    type: str = "a table"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        """Return the dataclass."""
        part = table.table(entry.name)
        return None if part is None else read_part(self.cls, part)

    def write(self, value: Any, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        """Return the table with its name."""
        return {entry.name: write_fields(value, folder)}


class Tables:
    """Dataclasses in an array of tables.

    Args:
        name: Name of the array.
        cls: The dataclass.
        at_most: Largest number of tables.
    """

    def __init__(self, name: str, cls: type[Any], at_most: int) -> None:
        self.type = f"at least one [[{name}]] table"
        self.cls, self.tables, self.at_most = cls, {f"[{name}]": cls}, at_most

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Any:
        """Return the complete dataclasses."""
        found = [read_part(self.cls, part) for part in table.tables(entry.name, self.at_most)]
        return tuple(one for one in found if one is not None)


class OtherKeys(NamedTuple):
    """All keys of a table that are not read by other fields, as plain data."""

    type: str
    names: str = "..."

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> dict[str, Any]:
        """Return the keys."""
        return {key: table.value(key) for key in table.rest()}

    def write(self, value: Any, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        """Return the keys."""
        return dict(plain(value))


def pose_entries(T: pin.SE3) -> dict[str, Any]:
    """Return the keys of a pose that differ from the identity."""
    found: dict[str, Any] = {}
    if T.translation.any():
        found["position"] = _rounded(T.translation)
    if not (T.rotation == pin.SE3.Identity().rotation).all():
        found["quat_wxyz"] = _rounded(spatial.quat_wxyz(T))
    return found


def plain(value: Any) -> Any:
    """Return a value with lists in place of tuples and dicts in place of mappings."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def _rounded(numbers: Any) -> list[float]:
    return [round(float(x), _DIGITS) + 0.0 for x in numbers]


_TYPES: tuple[tuple[Any, Any], ...] = (
    (str, _Simple("a text", "text")),
    (float, _Number("a number", "number")),
    (int, _Number("a whole number", "whole_number")),
    (bool, _Simple("true or false", "flag")),
    (tuple[float, ...], _Numbers("a list of numbers", "numbers")),
    (tuple[float, float], _Numbers("a list of numbers", "numbers")),
    (tuple[str, ...], _Names("a list of names", "texts")),
    (tuple[tuple[str, str], ...], _Pairs("a list of pairs of names", "name_pairs")),
    (pin.SE3, _Pose()),
)


def _values_of(hint: Any) -> Any:
    """Return the reader and writer of a type, or of its alternative to None."""
    if get_origin(hint) in (Union, types.UnionType):
        (hint,) = (one for one in get_args(hint) if one is not type(None))
    if get_origin(hint) is Annotated:
        hint = get_args(hint)[0]
    if is_dataclass(hint):
        return Part(hint)  # type: ignore[arg-type]
    return next(values for known, values in _TYPES if known == hint)
