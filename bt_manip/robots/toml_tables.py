"""Reading the tables of a TOML file, so that whatever is wrong is said with its place."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pinocchio as pin

from bt_manip import spatial
from bt_manip.exceptions import did_you_mean

from .errors import RobotError


class TomlTable:
    """A table of a file, read key by key; `finish` finds the keys that nobody asked for."""

    def __init__(self, file: Path, entries: Mapping[str, Any], name: str = "") -> None:
        """Read a table.

        Args:
            file: Where it is, for messages.
            entries: What is in it.
            name: What it is called in the file; empty for the file itself.
        """
        self._file, self._entries, self._name = file, entries, name
        self._asked: list[str] = []

    def error(self, key: str, message: str) -> RobotError:
        """Make an error about a key."""
        return RobotError(f"{self._file}: key '{self._full(key)}' {message}")

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
        """Give the pose that ``position`` and ``quat_wxyz`` of the table say."""
        position = self.numbers("position", 3) or (0.0, 0.0, 0.0)
        quat = self.numbers("quat_wxyz", 4) or (1.0, 0.0, 0.0, 0.0)
        try:
            return spatial.pose(position, quat)
        except ValueError as error:
            raise self.error("quat_wxyz", f"is no rotation: {error}") from None

    def table(self, key: str) -> "TomlTable | None":
        """Give a table inside, or None where there is none."""
        value = self._get(key)
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.error(key, f"is a table, got {value!r}")
        return TomlTable(self._file, value, self._full(key))

    def finish(self) -> None:
        """Refuse keys that mean nothing.

        Raises:
            RobotError: When there is one; nearest right keys are offered.
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
        return f"{self._name}.{key}" if self._name else key


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
