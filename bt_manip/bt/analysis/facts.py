"""What is known of the blackboard and the cell at a node, over all ways that lead there.

Facts map a variable to the set of its possible values. A variable that is missing has the values
that `unknown` gives: an entry was not written, and of a fact of the cell nothing is known.
"""

from collections.abc import Hashable, Mapping
from typing import Any, Final, NamedTuple

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.port_types import PortType

MAX_CONSTANTS: Final = 8
"""Number of constants of an entry that are told apart."""


class EntryName(NamedTuple):
    """The variable of a blackboard entry.

    Attributes:
        scope: The identity of its scope.
        key: Its key there.
    """

    scope: int
    key: str


class Fact(NamedTuple):
    """The variable of a fact of the cell.

    Attributes:
        robot: The robot, as `robot_of` tells robots apart.
        name: The fact in words.
    """

    robot: Hashable
    name: str


class Constant(NamedTuple):
    """A value of an entry that is known before the run."""

    value: Any
    type: PortType


UNWRITTEN: Final = "never written"
WRITTEN: Final = "some value"

Values = frozenset[Any]
Facts = Mapping[EntryName | Fact, Values]

_NOT_WRITTEN: Final = frozenset({UNWRITTEN})
_ANYTHING: Final = frozenset({WRITTEN})
_EITHER: Final = frozenset({True, False})


def unknown(variable: EntryName | Fact) -> Values:
    """Return the values of a variable of which nothing is known."""
    return _NOT_WRITTEN if isinstance(variable, EntryName) else _EITHER


def values_of(facts: Facts, variable: EntryName | Fact) -> Values:
    """Return the possible values of a variable."""
    return facts.get(variable) or unknown(variable)


def join(first: Facts | None, second: Facts | None) -> Facts:
    """Return the facts of two ways together; `first` itself if `second` adds nothing."""
    if first is None or second is None or first == second:
        return first if first is not None else second or {}
    more: dict[EntryName | Fact, Values] = {}
    changed = [v for v, values in second.items() if first.get(v) is not values]
    for variable in (*changed, *(first.keys() - second.keys())):
        before = values_of(first, variable)
        after = before | values_of(second, variable)
        if len(after) > MAX_CONSTANTS:
            after = _ANYTHING | (after & _NOT_WRITTEN)
        if after != before:
            more[variable] = after
    return {**first, **more} if more else first


def written(facts: Facts, values: Mapping[EntryName, Constant | None]) -> Facts:
    """Return the facts after entries were written; None for a value that is not known."""
    if not values:
        return facts
    new: dict[EntryName | Fact, Values] = {
        entry: _ANYTHING if value is None or not _is_hashable(value) else frozenset({value})
        for entry, value in values.items()
    }
    return {**facts, **new}


def _is_hashable(value: Constant) -> bool:
    return isinstance(value.value, str | int | float | bool)


def variable_of(scope: Blackboard, key: str) -> EntryName:
    """Return the variable of the entry that a key of a scope means."""
    owner, own_key = scope.place(key)
    return EntryName(id(owner), own_key)
