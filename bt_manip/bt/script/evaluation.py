"""The values of the scripting language, and what a script sees.

A value travels with its type, as ``(value, type)``: arithmetic gives doubles, while a literal or a
variable keeps its type until it is calculated with.
"""

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from bt_manip.bt.blackboard import EMPTY, Blackboard
from bt_manip.bt.port_types import BOOL, DOUBLE, STRING, PortType, cast
from bt_manip.exceptions import ScriptError

Value = tuple[Any, PortType]
"""A value and its type."""

NUMBERS: Final = ("integer", "real")
EPSILON: Final = 2.0**-23
"""Numbers that differ by no more are equal: the rounding error of single precision."""

NOTHING: Final = PortType("nothing: [..] joins texts, and both operands are numbers", None)
"""The type of what two numbers joined by ``..`` give."""


class Environment(NamedTuple):
    """What a script sees: a blackboard scope, and numbers by name."""

    scope: Blackboard
    enums: Mapping[str, int]


Expression = Callable[[Environment], Value]
"""A compiled piece of a script."""


def is_true(value: Value) -> bool:
    """Tell whether the value of a condition is true.

    Raises:
        ScriptError: If it is a text, a negative number, or an integer beside 0 and 1.
    """
    content, type = value
    if content is EMPTY:
        raise ScriptError(f"the value of the condition {missing(value)}")
    if type.family not in NUMBERS:
        raise ScriptError(f"{content!r} is neither true nor false")
    try:
        return bool(cast(content, type, BOOL))
    except ValueError as error:
        raise ScriptError(str(error)) from None


def as_double(value: Value) -> float:
    """Give a number as a double.

    Raises:
        ScriptError: If a double does not hold it exactly.
    """
    try:
        return float(cast(value[0], value[1], DOUBLE))
    except ValueError as error:
        raise ScriptError(str(error)) from None


def text_as_double(text: str, enums: Mapping[str, int]) -> float:
    """Give the number that a text stands for: a truth value, an enumeration's name, or a number.

    Raises:
        ScriptError: If it is none of these.
    """
    if text == "true":
        return 1.0
    if text == "false":
        return 0.0
    if text in enums:
        return float(enums[text])
    try:
        return float(cast(text, STRING, DOUBLE))
    except ValueError as error:
        raise ScriptError(f"{error}, and no enumeration has it") from None


def missing(value: Value) -> str:
    """Say in which way a value is missing."""
    return f"is {value[1].name}" if value[1] is NOTHING else "was never written"


class Name:
    """A variable, or a number of an enumeration, which comes first."""

    __slots__ = ("key",)

    def __init__(self, key: str) -> None:
        """Name a blackboard key."""
        self.key = key

    def __call__(self, env: Environment) -> Value:
        """Give the variable's value."""
        key = self.key
        if key in env.enums:
            return float(env.enums[key]), DOUBLE
        entry = env.scope.entry(key)
        if entry is None:
            raise ScriptError(f"variable not found: {key}")
        return entry.value, entry.type
