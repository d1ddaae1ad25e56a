"""What is known at a node over all ways that lead there: variables with their possible values.

A variable is an entry of the blackboard or a fact of the cell. An entry without values was not
written; of a fact without values nothing is known.
"""

from collections.abc import Hashable, Iterable, Mapping
from typing import Any, Final, NamedTuple

from bt_manip.bt.blackboard import EMPTY, Blackboard
from bt_manip.bt.port_types import PortType
from bt_manip.bt.status import FAILURE, SKIPPED, SUCCESS, NodeStatus

COMPLETE: Final = (SUCCESS, FAILURE, SKIPPED)

MAX_CONSTANTS: Final = 8
"""Number of constants of an entry that are told apart."""


class EntryName(NamedTuple):
    """An entry of the blackboard: the identity of its scope, and its key there."""

    scope: int
    key: str


class Fact(NamedTuple):
    """A fact of the cell, such as ``holding``, about a robot as `robot_of` tells robots apart."""

    robot: Hashable
    name: str


class Constant(NamedTuple):
    """A value of an entry that is known before the run."""

    value: Any
    type: PortType


UNWRITTEN: Final = "never written"
WRITTEN: Final = "some value"

Variable = EntryName | Fact
Values = frozenset[Any]
Facts = Mapping[Variable, Values]

ENDED: Final[Facts] = {Fact("", "ended"): frozenset({True})}
"""What holds after an error that ends the run, such as that of a script."""

_NOT_WRITTEN: Final = frozenset({UNWRITTEN})
_ANYTHING: Final = frozenset({WRITTEN})
_EITHER: Final = frozenset({True, False})


def values_of(facts: Facts, variable: Variable) -> Values:
    """Return the possible values of a variable."""
    return facts.get(variable) or (_NOT_WRITTEN if isinstance(variable, EntryName) else _EITHER)


def constant_in(values: Values) -> Constant | None:
    """Return the constant that is the only possible value."""
    one = next(iter(values))
    return one if len(values) == 1 and isinstance(one, Constant) else None


def join(first: Facts, second: Facts) -> Facts:
    """Return the facts of two ways together; `first` itself if `second` adds nothing, or ended."""
    if first is second or first == second or second.items() >= ENDED.items():
        return first
    more: dict[Variable, Values] = {}
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
    new: dict[Variable, Values] = {}
    for entry, one in values.items():
        is_known = one is not None and isinstance(one.value, str | int | float | bool)
        new[entry] = frozenset({one}) if is_known else _ANYTHING
    return {**facts, **new} if new else facts


def variable_of(scope: Blackboard, key: str) -> EntryName:
    """Return the variable of the entry that a key of a scope means."""
    owner, own_key = scope.place(key)
    return EntryName(id(owner), own_key)


def constants(scopes: Iterable[Blackboard]) -> dict[EntryName, Constant]:
    """Return the entries of scopes that have a value."""
    entries = ((id(scope), key, one) for scope in scopes for key, one in scope.entries.items())
    return {
        EntryName(scope, key): Constant(one.value, one.type)
        for scope, key, one in entries
        if one.value is not EMPTY
    }


class Way(NamedTuple):
    """The ways to a status: what holds then, and the shortest time that they take [ms]."""

    facts: Facts
    least: float = 0.0


Ways = Mapping[NodeStatus, Way]
"""What a node can answer: its possible statuses. What holds while it runs holds when it is halted,
too."""


def both(first: Way, second: Way) -> Way:
    """Return two ways together."""
    return Way(join(first.facts, second.facts), min(first.least, second.least))


def either(*alternatives: Ways) -> dict[NodeStatus, Way]:
    """Return the ways of all alternatives."""
    found: dict[NodeStatus, Way] = {}
    for ways in alternatives:
        for status, way in ways.items():
            found[status] = both(found[status], way) if status in found else way
    return found


def later(ways: Ways, after: float) -> Ways:
    """Return ways that begin some time later [ms]."""
    return {s: Way(way.facts, way.least + after) for s, way in ways.items()} if after else ways


def least(ways: Ways) -> float:
    """Return the shortest time until a node completes [ms]; infinite if it never does."""
    return min((ways[one].least for one in COMPLETE if one in ways), default=float("inf"))
