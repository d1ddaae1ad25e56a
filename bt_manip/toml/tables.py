"""Typed reading of TOML tables; error messages name file, line and key."""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.exceptions import BtManipError, did_you_mean, shown
from bt_manip.files import read_text
from bt_manip.parameters import Parameter

from .lines import Place, line_numbers, line_of
from .parsing import MAX_TOML_BYTES, parse_toml

LARGEST = 1e10
"""Largest absolute value of a number in SI units: MuJoCo's bound for diverged states."""


UNBOUNDED = Parameter()


class TomlFile:
    """A TOML file, read table by table; errors about keys are collected.

    Args:
        what: Kind of the file, for messages.

    Attributes:
        path: The file.
        error: Type of errors about its content.
        problems: The errors about keys, raised when the outermost table is finished.

    Raises:
        BtManipError: Of type `error`, if there is no such file or it is not valid TOML.
    """

    def __init__(self, path: Path, what: str, error: type[BtManipError]) -> None:
        self.path, self.error = path, error
        self.problems: list[BtManipError] = []
        try:
            text = read_text(path, MAX_TOML_BYTES)
            self._entries = parse_toml(text)
        except OSError as problem:
            raise error(f"no {what} {path}: {problem.strerror}") from problem
        except ValueError as problem:
            raise error(f"{path}: not a TOML file: {problem}") from problem
        self._lines = line_numbers(text)

    @property
    def whole(self) -> "TomlTable":
        """The root table of the file."""
        return TomlTable(self, self._entries)

    def where(self, place: Place) -> str:
        """Return the location of a key: the file, and the line if known."""
        line = line_of(place, self._lines)
        return str(self.path) if line is None else f"{self.path}:{line}"

    def joined(self, problems: Sequence[BtManipError]) -> BtManipError:
        """Return one error with all problems, each in a line."""
        return self.error("\n".join(map(str, problems)))


class PythonSource(NamedTuple):
    """Source of a table defined in Python."""

    name: str
    error: type[BtManipError]

    def where(self, place: Place) -> str:
        """Return the name of the source."""
        return self.name


class TomlTable:
    """A table of a file, read key by key; `finish` rejects keys that were not read.

    Args:
        file: Source of the table.
        entries: Content of the table.
        place: Path of the table in the file; empty for the root table.
    """

    def __init__(
        self, file: TomlFile | PythonSource, entries: Mapping[str, Any], place: Place = ()
    ) -> None:
        self.file, self._entries, self._place = file, entries, place
        self._asked: list[str] = []
        self._inner = False
        self._rejected: set[str] = set()

    def error(self, key: str, message: str) -> BtManipError:
        """Return an error about a key."""
        where = self.file.where((*self._place, key))
        return self.file.error(f"{where}: key '{self._full(key)}' {message}")

    def reject(self, key: str, message: str) -> None:
        """Collect the first error about each key of a file; raise one of a table from Python."""
        problem = self.error(key, message)
        if not isinstance(self.file, TomlFile):
            raise problem from None
        if key not in self._rejected:
            self._rejected.add(key)
            self.file.problems.append(problem)

    def keys(self) -> tuple[str, ...]:
        """Return the keys of the table."""
        return tuple(self._entries)

    def value(self, key: str) -> Any:
        """Return the value of a key, with finite numbers, or None if missing."""
        value = self._get(key)
        for number in _numbers_in(value):
            self._check_size(key, number)
        return value

    def text(self, key: str) -> str | None:
        """Return a string, or None if missing."""
        return self._typed(key, lambda value: isinstance(value, str) and value, "a text")

    def needed_text(self, key: str) -> str:
        """Return a required string."""
        return str(self.text(key)) if self.require(key, "a text") else ""

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a required list of strings."""
        if not self.require(key, "a list of names"):
            return ()
        return tuple(self._typed(key, lambda value: _is_list(value, str), "a list of names", ()))

    def name_pairs(self, key: str) -> tuple[tuple[str, str], ...]:
        """Return a list of pairs of names; an empty one if missing."""
        what = 'a list of pairs of names, [["a", "b"]]'
        return tuple((a, b) for a, b in self._typed(key, _are_name_pairs, what, ()))

    def number(self, key: str, *, bounds: Parameter = UNBOUNDED) -> float | None:
        """Return a finite number within bounds, or None if missing."""
        value = self._typed(key, _is_number, "a number")
        return None if value is None or not self._check_size(key, value, bounds) else float(value)

    def numbers(
        self,
        key: str,
        size: int | None = None,
        *,
        spread: bool = False,
        bounds: Parameter = UNBOUNDED,
    ) -> tuple[float, ...] | None:
        """Return a list of finite numbers within bounds, or None if missing.

        Args:
            key: The key.
            size: Required length; None for any.
            spread: Whether to accept a single number, repeated if there is a length.
            bounds: Bounds of each of them.
        """
        value = self._get(key)
        if value is None:
            return None
        if spread and _is_number(value):
            value = [value] * (1 if size is None else size)
        count = "" if size is None else f"{size} "
        if not isinstance(value, list) or not all(_is_number(item) for item in value):
            self.reject(key, f"is a list of {count}numbers, got {shown(value)}")
            return None
        if size is not None and len(value) != size:
            self.reject(key, f"is a list of {size} numbers, got {len(value)}")
            return None
        if not all([self._check_size(key, item, bounds) for item in value]):
            return None
        return tuple(float(item) for item in value)

    def pose(self) -> pin.SE3:
        """Return the pose from the keys ``position`` [m] and ``quat_wxyz`` or ``rpy`` [rad]."""
        position = self.numbers("position", 3) or (0.0, 0.0, 0.0)
        return spatial.pose(position, self.turn())

    def turn(self) -> tuple[float, ...]:
        """Return the orientation from the key ``quat_wxyz`` or ``rpy`` [rad], as a quaternion.

        Roll, pitch and yaw are rotations about fixed axes, in this order.
        """  # (4,)
        quat, rpy = self.numbers("quat_wxyz", 4), self.numbers("rpy", 3)
        if quat is not None and rpy is not None:
            self.reject("rpy", "and 'quat_wxyz' exclude each other: give one of them")
        if rpy is not None:
            T = pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.zeros(3))
            return tuple(spatial.quat_wxyz(T).tolist())
        try:
            spatial.pose((0.0, 0.0, 0.0), quat or (1.0, 0.0, 0.0, 0.0))
        except ValueError as error:
            self.reject("quat_wxyz", f"is no rotation: {error}")
            return (1.0, 0.0, 0.0, 0.0)
        return quat or (1.0, 0.0, 0.0, 0.0)

    def require(self, key: str, what: str) -> bool:
        """Return whether the table has a required key, and reject it if not.

        Args:
            key: The key.
            what: Its type, for the message.
        """
        if key not in self._entries:
            self._asked.append(key)
            near = [k for k in self._entries if k not in self._asked]
            self.reject(key, f"is missing: {what}" + (did_you_mean(key, near) if near else ""))
        return key in self._entries

    def flag(self, key: str) -> bool | None:
        """Return a boolean, or None if missing."""
        return self._typed(key, lambda value: isinstance(value, bool), "true or false")

    def whole_number(self, key: str, *, bounds: Parameter = UNBOUNDED) -> int | None:
        """Return an integer within bounds, or None if missing."""
        value = self._typed(
            key, lambda value: _is_number(value) and isinstance(value, int), "a whole number"
        )
        return value if value is None or self._is_within(key, value, bounds) else None

    def table(self, key: str) -> "TomlTable | None":
        """Return a subtable, or None if missing."""
        value = self._typed(key, lambda value: isinstance(value, dict), "a table")
        return None if value is None else self._part(value, key)

    def variant(self, key: str, without: Container[str], **given: Any) -> "TomlTable":
        """Return a subtable with this table's entries where it has none.

        Args:
            key: Key of the subtable.
            without: Keys of this table that it does not take.
            **given: Entries in place of those of this table.
        """
        rest = {name: value for name, value in self._entries.items() if name not in without}
        return self._part({**rest, **given, **self._entries[key]}, key)

    def tables(self, key: str, at_most: float = inf) -> list["TomlTable"]:
        """Return the tables of an array of tables; an empty list if missing, or if too many."""
        value = self._get(key, [])
        if not _is_list(value, dict):
            self.reject(key, f"is an array of tables, each under [[{self._full(key)}]]")
            return []
        if len(value) > at_most:
            self.reject(key, f"has {len(value)} tables; a file has at most {at_most}")
            return []
        return [self._part(item, key, number) for number, item in enumerate(value, 1)]

    def rest(self) -> dict[str, Any]:
        """Return the entries that were not read."""
        return {key: value for key, value in self._entries.items() if key not in self._asked}

    def finish(self) -> None:
        """Reject keys that were not read.

        Raises:
            BtManipError: If there is such a key; the nearest known keys are suggested. The
                outermost table of a file raises all collected errors, one per line.
        """
        for key in self._entries:
            if key not in self._asked:
                self.reject(key, f"means nothing{did_you_mean(key, self._asked)}")
        if isinstance(self.file, TomlFile) and not self._inner:
            problems, self.file.problems = self.file.problems, []
            if problems:
                raise self.file.joined(problems)

    def _part(self, entries: Mapping[str, Any], *place: str | int) -> "TomlTable":
        part = TomlTable(self.file, entries, (*self._place, *place))
        part._inner = True
        return part

    def _check_size(self, key: str, value: float, bounds: Parameter = UNBOUNDED) -> bool:
        """Return whether a number is within bounds, and reject its key if not."""
        if not -LARGEST <= value <= LARGEST:  # also NaN, and integers beyond floats
            self.reject(
                key, f"is a finite number of at most {LARGEST:g} in size, got {shown(value)}"
            )
            return False
        return self._is_within(key, value, bounds)

    def _is_within(self, key: str, value: float, bounds: Parameter) -> bool:
        if bounds.within(value):
            return True
        self.reject(key, f"is {bounds.wanted_number}, got {shown(value)}")
        return False

    def _typed(
        self, key: str, valid: Callable[[Any], object], what: str, default: Any = None
    ) -> Any:
        """Return the value of a key; the default if it is missing, or invalid and rejected."""
        value = self._get(key, default)
        if value is default or valid(value):
            return value
        self.reject(key, f"is {what}, got {shown(value)}")
        return default

    def _get(self, key: str, default: Any = None) -> Any:
        self._asked.append(key)
        return self._entries.get(key, default)

    def _full(self, key: str) -> str:
        text = ""
        for part in (*self._place, key):
            text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
        return text


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_list(value: Any, of: type) -> bool:
    return isinstance(value, list) and all(isinstance(item, of) for item in value)


def _are_name_pairs(value: Any) -> bool:
    return _is_list(value, list) and all(
        len(pair) == 2 and _is_list(pair, str) and all(pair) for pair in value
    )


def _numbers_in(value: Any) -> Iterator[float]:
    """Yield all numbers in nested lists and tables."""
    if _is_number(value):
        yield value
    elif isinstance(value, list | tuple | dict):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _numbers_in(item)
