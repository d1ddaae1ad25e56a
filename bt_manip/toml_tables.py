"""Reading the tables of a TOML file, so that whatever is wrong is said with its place."""

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.toml_lines import Place, line_numbers, line_of

T = TypeVar("T")


class TomlFile:
    """A file that is read table by table.

    Attributes:
        path: The file.
        error: What is raised when something in it is wrong.
        problems: What `attempt` has caught.
    """

    def __init__(self, path: Path, what: str, error: type[BtManipError]) -> None:
        """Read a file.

        Args:
            path: The file.
            what: What it is, for messages.
            error: What to raise when something in it is wrong.

        Raises:
            BtManipError: Of that type, when there is no such file or it is not TOML.
        """
        self.path, self.error = path, error
        self.problems: list[BtManipError] = []
        try:
            text = path.read_text(encoding="utf-8")
            self._entries = tomllib.loads(text)
        except OSError as problem:
            raise error(f"no {what} {path}: {problem.strerror}") from problem
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as problem:
            raise error(f"{path}: not a TOML file: {problem}") from problem
        self._lines = line_numbers(text)

    @property
    def whole(self) -> "TomlTable":
        """The table that the file itself is."""
        return TomlTable(self, self._entries)

    def where(self, place: Place) -> str:
        """Say where a key is: the file, and the line where it is known."""
        line = line_of(place, self._lines)
        return str(self.path) if line is None else f"{self.path}:{line}"

    def attempt(self, read: Callable[..., T], *arguments: Any, **named: Any) -> T | None:
        """Read something; keep what is wrong with it for later, and give None."""
        try:
            return read(*arguments, **named)
        except BtManipError as problem:
            self.problems.append(problem)
            return None


class PythonSource(NamedTuple):
    """Stands for the file of a table that was written in Python."""

    name: str
    error: type[BtManipError]

    def where(self, place: Place) -> str:
        """Say whose table it is."""
        return self.name


class TomlTable:
    """A table of a file, read key by key; `finish` finds the keys that nobody asked for."""

    def __init__(
        self, file: TomlFile | PythonSource, entries: Mapping[str, Any], place: Place = ()
    ) -> None:
        """Read a table.

        Args:
            file: Where it is.
            entries: What is in it.
            place: What it is called in the file; empty for the file itself.
        """
        self.file, self._entries, self._place = file, entries, place
        self._asked: list[str] = []

    def error(self, key: str, message: str) -> BtManipError:
        """Make an error about a key."""
        where = self.file.where((*self._place, key))
        return self.file.error(f"{where}: key '{self._full(key)}' {message}")

    def keys(self) -> tuple[str, ...]:
        """Name what is in the table."""
        return tuple(self._entries)

    def value(self, key: str) -> Any:
        """Give whatever a key has, or None where there is none."""
        return self._get(key)

    def text(self, key: str, default: str | None = None) -> str | None:
        """Give a text, or the default where there is none."""
        value = self._get(key, default)
        if value is not default and (not isinstance(value, str) or not value):
            raise self.error(key, f"is a text, got {value!r}")
        return value

    def needed_text(self, key: str) -> str:
        """Give a text that must be there."""
        self._need(key, "a text")
        return str(self.text(key))

    def texts(self, key: str) -> tuple[str, ...]:
        """Give a list of texts that must be there."""
        self._need(key, "a list of names")
        value = self._get(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.error(key, f"is a list of names, got {value!r}")
        return tuple(value)

    def number(self, key: str, default: float | None = None) -> float | None:
        """Give a number, or the default where there is none."""
        value = self._get(key, default)
        if value is not default and not _is_number(value):
            raise self.error(key, f"is a number, got {value!r}")
        return None if value is None else float(value)

    def needed_number(self, key: str) -> float:
        """Give a number that must be there."""
        self._need(key, "a number")
        value = self.number(key)
        assert value is not None
        return value

    def numbers(
        self, key: str, size: int | None = None, *, spread: bool = False
    ) -> tuple[float, ...] | None:
        """Give a list of numbers, or None where there is none.

        Args:
            key: Where it is.
            size: How many there must be.
            spread: Whether one number stands for as many equal ones.
        """
        value = self._get(key)
        if value is None:
            return None
        if spread and size is not None and _is_number(value):
            return (float(value),) * size
        count = "" if size is None else f"{size} "
        if not isinstance(value, list) or not all(_is_number(item) for item in value):
            raise self.error(key, f"is a list of {count}numbers, got {value!r}")
        if size is not None and len(value) != size:
            raise self.error(key, f"is a list of {size} numbers, got {len(value)}")
        return tuple(float(item) for item in value)

    def needed_numbers(self, key: str, size: int) -> tuple[float, ...]:
        """Give a list of numbers that must be there; one number stands for equal ones."""
        self._need(key, f"{size} numbers")
        value = self.numbers(key, size, spread=True)
        assert value is not None
        return value

    def pose(self) -> pin.SE3:
        """Give the pose that ``position`` [m] and ``quat_wxyz``, or ``rpy`` [rad], say."""
        position = self.numbers("position", 3) or (0.0, 0.0, 0.0)
        return spatial.pose(position, self.turn())

    def turn(self) -> tuple[float, ...]:
        """Give the orientation that ``quat_wxyz``, or ``rpy`` [rad], says, as a quaternion.

        Roll, pitch and yaw turn about the axes of the world, in this order.
        """  # (4,)
        quat, rpy = self.numbers("quat_wxyz", 4), self.numbers("rpy", 3)
        if quat is not None and rpy is not None:
            raise self.error("rpy", "and 'quat_wxyz' say the same twice: one is enough")
        if rpy is not None:
            T = pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.zeros(3))
            return tuple(spatial.quat_wxyz(T).tolist())
        try:
            spatial.pose((0.0, 0.0, 0.0), quat or (1.0, 0.0, 0.0, 0.0))
        except ValueError as error:
            raise self.error("quat_wxyz", f"is no rotation: {error}") from None
        return quat or (1.0, 0.0, 0.0, 0.0)

    def flag(self, key: str) -> bool | None:
        """Give true or false, or None where there is neither."""
        value = self._get(key)
        if value is not None and not isinstance(value, bool):
            raise self.error(key, f"is true or false, got {value!r}")
        return value

    def whole_number(self, key: str) -> int | None:
        """Give a whole number, or None where there is none."""
        value = self._get(key)
        if value is not None and (not isinstance(value, int) or isinstance(value, bool)):
            raise self.error(key, f"is a whole number, got {value!r}")
        return value

    def table(self, key: str) -> "TomlTable | None":
        """Give a table inside, or None where there is none."""
        value = self._get(key)
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.error(key, f"is a table, got {value!r}")
        return TomlTable(self.file, value, (*self._place, key))

    def tables(self, key: str) -> list["TomlTable"]:
        """Give the tables of an array, none where there is no such array."""
        value = self._get(key)
        if value is None:
            return []
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.error(key, f"is an array of tables, each under [[{self._full(key)}]]")
        return [
            TomlTable(self.file, item, (*self._place, key, number))
            for number, item in enumerate(value, 1)
        ]

    def rest(self) -> dict[str, Any]:
        """Give the keys that nobody has asked for, with their values."""
        return {key: value for key, value in self._entries.items() if key not in self._asked}

    def finish(self) -> None:
        """Refuse keys that mean nothing.

        Raises:
            BtManipError: When there is one; nearest right keys are offered.
        """
        for key in self._entries:
            if key not in self._asked:
                raise self.error(key, f"means nothing{did_you_mean(key, self._asked)}")

    def _get(self, key: str, default: Any = None) -> Any:
        self._asked.append(key)
        return self._entries.get(key, default)

    def _need(self, key: str, what: str) -> None:
        if key not in self._entries:
            self._asked.append(key)
            near = [k for k in self._entries if k not in self._asked]
            raise self.error(key, f"is missing: {what}" + (did_you_mean(key, near) if near else ""))

    def _full(self, key: str) -> str:
        text = ""
        for part in (*self._place, key):
            text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
        return text


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
