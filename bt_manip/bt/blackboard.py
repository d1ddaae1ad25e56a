"""The scoped, typed blackboard: one scope for each instance of a sub-tree."""

import inspect
import re
from typing import Any, Final

from bt_manip.bt import literals
from bt_manip.bt.port_types import (
    BOOL,
    DOUBLE,
    INT,
    INT64,
    STRING,
    UNTYPED,
    PortType,
    cast,
    casts_safely,
    type_of,
)
from bt_manip.exceptions import BlackboardError, did_you_mean, shown


class _Empty:
    """The value of an entry that was declared and never written."""

    def __repr__(self) -> str:
        return "EMPTY"


EMPTY: Final = _Empty()

_NUMBERS: Final = ("integer", "real")
_INTEGER: Final = re.compile(r"-?[0-9]+")


class Entry:
    """One value of a blackboard, with its type.

    Attributes:
        declared: The type that was declared, by a port or by the first write.
        value: The value, or `EMPTY`.
        type: The type of the value; it may be another than the declared one.
        sequence: How often the entry was written.
    """

    __slots__ = ("declared", "sequence", "type", "value")

    def __init__(self, declared: PortType) -> None:
        self.declared = declared
        self.value: Any = EMPTY
        self.type = declared
        self.sequence = 0

    def put(self, value: Any, type: PortType) -> None:
        """Replace value and type, without any check."""
        self.value = value
        self.type = type
        self.sequence += 1

    def copy_in(self, value: Any, type: PortType) -> None:
        """Write a value and keep the type that the entry's value has.

        Raises:
            ValueError: If the value does not become that type without loss.
        """
        if self.value is EMPTY:
            self.put(value, type)
            return
        family = self.type.family
        if family != type.family:
            if family not in _NUMBERS or type.family not in _NUMBERS:
                raise ValueError(f"a value of type {type.name} does not become {self.type.name}")
            # All integers are kept as 64 bit: a narrower type of the value is no limit here.
            value = cast(value, type, DOUBLE if family == "real" else INT64)
        elif family == "object" and type != self.type:
            raise ValueError(f"a value of type {type.name} does not become {self.type.name}")
        elif self.type is BOOL and value in (0, 1):
            value = bool(value)
        self.value = value
        self.sequence += 1


class Blackboard:
    """The entries that one tree sees, and where the others of its keys are found.

    A key that is not here is looked up where `remap` says, else, with `autoremap`, under the same
    name in the parent. Keys that start with ``_`` are private: they are never looked up
    automatically. ``@key`` always means the scope of the root.

    Attributes:
        parent: The scope of the tree that holds this sub-tree.
        entries: The entries of this scope by key.
        remapped: The parent's keys by own keys.
        autoremap: Whether all other keys are the parent's too.
    """

    def __init__(self, parent: "Blackboard | None" = None) -> None:
        self.parent = parent
        self.entries: dict[str, Entry] = {}
        self.remapped: dict[str, str] = {}
        self.autoremap = False
        self.root: Blackboard = self if parent is None else parent.root

    def remap(self, key: str, parent_key: str) -> None:
        """Let a key of this scope mean a key of the parent; the first remap of a key counts."""
        self.remapped.setdefault(key, parent_key)

    def entry(self, key: str) -> Entry | None:
        """Find the entry behind a key, here or where the key leads; None if there is none."""
        if key[:1] == "@":  # before all else: a remap may have made an entry of that very name
            return self.root.entry(key[1:])
        entry = self.entries.get(key)
        if entry is not None:
            return entry
        parent = self.parent
        if parent is not None:
            parent_key = self.remapped.get(key)
            if parent_key is not None:
                return parent.entry(parent_key)
            if self.autoremap and key[:1] != "_":
                return parent.entry(key)
        return None

    def place(self, key: str) -> tuple["Blackboard", str]:
        """Return the scope in which the entry behind a key is or would be, and its key there."""
        if key[:1] == "@":
            return self.root.place(key[1:])
        if key not in self.entries and self.parent is not None:
            if key in self.remapped:
                return self.parent.place(self.remapped[key])
            if self.autoremap and key[:1] != "_":
                return self.parent.place(key)
        return self, key

    def declare(self, key: str, type: PortType = UNTYPED) -> Entry:
        """Find or create the entry behind a key, where the key leads.

        Raises:
            BlackboardError: If the entry exists with another type.
        """
        if key[:1] == "@":
            if "@" in key[1:]:
                raise BlackboardError(f"'@' stands more than once in the key '{key}'")
            return self.root._declare(key[1:], type)
        return self._declare(key, type)

    def _declare(self, key: str, type: PortType) -> Entry:
        entry = self.entries.get(key)
        if entry is not None:
            if entry.declared.strong and type.strong and entry.declared != type:
                raise BlackboardError(
                    f"entry '{key}' holds {entry.declared.name}; it cannot become {type.name}"
                )
            return entry
        if self.parent is not None:
            parent_key = self.remapped.get(key)
            if parent_key is not None:
                return self.parent._declare(parent_key, type)
            if self.autoremap and key[:1] != "_":
                return self.parent._declare(key, type)
        elif key in self.remapped:
            raise BlackboardError(f"'{key}' is remapped, but this scope has no parent")
        created = Entry(type)
        self.entries[key] = created
        return created

    def write(self, key: str, value: Any, type: PortType) -> None:
        """Write a value of a known type.

        The first write of a key declares its type, except that a string leaves it open. Later
        writes keep the type: numbers are cast where nothing is lost, and texts are converted.

        Raises:
            BlackboardError: If the entry does not take the value.
        """
        if key[:1] == "@":
            self.root.write(key[1:], value, type)
            return
        entry = self.entries.get(key)
        if entry is None:
            self._declare(key, UNTYPED if type is STRING else type).put(value, type)
            return
        if not entry.declared.strong:
            entry.declared = type
            entry.put(value, type)
            return
        declared = entry.declared
        try:
            if declared != type:
                if type is STRING and declared.converter is not None:
                    value, type = declared.converter(value), declared
                elif _is_instance(value, declared):
                    type = declared
                elif not casts_safely(value, type, declared):
                    raise ValueError(f"it was declared as {declared.name}")
            entry.copy_in(value, type)
        except ValueError as error:
            raise BlackboardError(
                f"entry '{key}' does not take {shown(value)} of type {type.name}: {error}"
            ) from None

    def unset(self, key: str) -> None:
        """Remove an entry of this scope; nothing happens if there is none."""
        self.entries.pop(key, None)

    def get(self, key: str, default: Any = None) -> Any:
        """Return the value behind a key, or a default if nothing was written."""
        entry = self.entry(key)
        return default if entry is None or entry.value is EMPTY else entry.value

    def __getitem__(self, key: str) -> Any:
        """Return the value behind a key.

        Raises:
            BlackboardError: If nothing was written under this key.
        """
        entry = self.entry(key)
        if entry is None:
            raise BlackboardError(f"no entry '{key}'" + did_you_mean(key, self.entries))
        if entry.value is EMPTY:
            raise BlackboardError(f"entry '{key}' was never written")
        return entry.value

    def __setitem__(self, key: str, value: Any) -> None:
        """Write a Python value; its type is found from the value."""
        type = type_of(value)
        if type is INT64 and -(1 << 31) <= value < 1 << 31:
            type = INT  # the type that a port of Python's int declares
        self.write(key, value, type)

    def set_text(self, key: str, text: str) -> None:
        """Write a constant given as text: an integer, a real number, or else a string.

        This is how a constant attribute of a ``<SubTree>`` enters its scope.
        """
        if _INTEGER.fullmatch(text):
            try:
                value = literals.parse_integer(text, 64)
            except ValueError:
                pass  # too long: a real number then
            else:
                self.write(key, value, INT if -(1 << 31) <= value < 1 << 31 else INT64)
                return
        try:
            self.write(key, literals.parse_real(text, whole=True), DOUBLE)
        except ValueError:
            self.write(key, text, STRING)

    def __contains__(self, key: object) -> bool:
        """Return whether a value was written under this key."""
        entry = self.entry(key) if isinstance(key, str) else None
        return entry is not None and entry.value is not EMPTY


def _is_instance(value: Any, type: PortType) -> bool:
    return (
        type.family == "object" and inspect.isclass(type.python) and isinstance(value, type.python)
    )
