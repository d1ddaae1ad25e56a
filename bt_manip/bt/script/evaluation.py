"""The values, operators and assignments of the scripting language.

A value travels with its type, as ``(value, type)``: arithmetic gives doubles, while a literal or a
variable keeps its type until it is calculated with.
"""

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from bt_manip.bt.blackboard import EMPTY, Blackboard, Entry
from bt_manip.bt.port_types import BOOL, DOUBLE, INT64, STRING, UNTYPED, PortType, cast
from bt_manip.exceptions import BlackboardError, ScriptError, shortened, shown

Value = tuple[Any, PortType]
"""A value and its type."""

NUMBERS: Final = ("integer", "real")
EPSILON: Final = 2.0**-23
"""Numbers that differ by no more are equal: the rounding error of single precision."""

MAX_TEXT: Final = 1_000_000
"""Length limit of the texts that scripts make [characters]; doubling in a loop ends there."""

NOTHING: Final = PortType("nothing: [..] joins texts, and both operands are numbers", None)
"""The type of the result of two numbers joined by ``..``."""


class Environment(NamedTuple):
    """The variables of a script: a blackboard scope, and numbers by name."""

    scope: Blackboard
    enums: Mapping[str, int]


Expression = Callable[[Environment], Value]
"""A compiled piece of a script."""


def is_true(value: Value) -> bool:
    """Return whether the value of a condition is true; raise a `ScriptError` if it is neither."""
    content, type = value
    if content is EMPTY:
        raise ScriptError(f"the value of the condition {missing(value)}")
    if type.family not in NUMBERS:
        raise ScriptError(f"{shown(content)} is neither true nor false")
    try:
        return bool(cast(content, type, BOOL))
    except ValueError as error:
        raise ScriptError(str(error)) from None


def as_double(value: Value) -> float:
    """Return a number as a double; raise a `ScriptError` if that does not hold it exactly."""
    try:
        return float(cast(value[0], value[1], DOUBLE))
    except ValueError as error:
        raise ScriptError(str(error)) from None


def text_as_double(text: str, enums: Mapping[str, int]) -> float:
    """Return the number of a text: a truth value, an enumeration's name, or a number."""
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
    """Return the reason why a value is missing."""
    return f"is {value[1].name}" if value[1] is NOTHING else "was never written"


class Name:
    """A variable, or a number of an enumeration, which comes first."""

    __slots__ = ("key",)

    def __init__(self, key: str) -> None:
        self.key = key

    def __call__(self, env: Environment) -> Value:
        """Return the variable's value."""
        key = self.key
        if key in env.enums:
            return float(env.enums[key]), DOUBLE
        entry = env.scope.entry(key)
        if entry is None:
            raise ScriptError(f"variable not found: {shortened(key)}")
        return entry.value, entry.type


def constant(value: Any, type: PortType) -> Expression:
    """Compile a literal."""
    pair = (value, type)
    return lambda env: pair


def unary(symbol: str, operand: Expression) -> Expression:
    """Compile ``-x``, ``~x`` or ``!x``."""

    def evaluate(env: Environment) -> Value:
        value = operand(env)
        if value[0] is EMPTY or value[1].family not in NUMBERS:
            raise ScriptError(f"operator [{symbol}] needs a number, found {shown(value[0])}")
        number = as_double(value)
        if symbol == "-":
            return -number, DOUBLE
        if symbol == "!":
            return float(number == 0), DOUBLE
        if not abs(number) <= 2.0**63:
            raise ScriptError(f"{number} is out of range for operator [~]")
        return float(~min(int(number), (1 << 63) - 1)), DOUBLE

    return evaluate


def chain(first: Expression, rest: list[tuple[str, Expression]]) -> Expression:
    """Compile operators of one strength, from the left: ``a + b - c``."""
    if len(rest) == 1:
        symbol, second = rest[0]
        return lambda env: binary(symbol, first(env), second(env))

    def evaluate(env: Environment) -> Value:
        value = first(env)
        for symbol, operand in rest:
            value = binary(symbol, value, operand(env))
        return value

    return evaluate


def binary(symbol: str, left: Value, right: Value) -> Value:
    """Apply an operator to two values; raise a `ScriptError` if it does not take them."""
    _check_written(symbol, left, right)
    left_family, right_family = left[1].family, right[1].family
    if left_family in NUMBERS and right_family in NUMBERS:
        return calculate(symbol, left, right)
    if symbol == "+" and left_family == right_family == "string":
        return join(left[0], right[0]), STRING
    if symbol == ".." and "string" in (left_family, right_family):
        known = ("string", *NUMBERS)
        if left_family in known and right_family in known:
            return join(as_text(left), as_text(right)), STRING
    raise ScriptError(f"operator [{symbol}] does not take {shown(left[0])} and {shown(right[0])}")


def calculate(symbol: str, left: Value, right: Value) -> Value:
    """Apply an operator to two numbers; raise a `ScriptError` if it does not take them."""
    a, b = as_double(left), as_double(right)
    if symbol in _ARITHMETIC:
        return _ARITHMETIC[symbol](a, b), DOUBLE
    if symbol == "..":
        return EMPTY, NOTHING
    if symbol in ("&&", "||"):
        a_true, b_true = is_true(left), is_true(right)
        return float(a_true and b_true if symbol == "&&" else a_true or b_true), DOUBLE
    try:
        i, j = cast(left[0], left[1], INT64), cast(right[0], right[1], INT64)
    except ValueError:
        raise ScriptError(f"operator [{symbol}] needs integers, found {a} and {b}") from None
    return float(_BITS[symbol](i, j)), DOUBLE


def divide(a: float, b: float) -> float:
    """Divide as floating point does: by zero, the result is infinite or no number."""
    if b != 0:
        return a / b
    if a == 0 or math.isnan(a):
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


_ARITHMETIC: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": divide,
}  # fmt: skip
_BITS: Final = {"&": operator.and_, "|": operator.or_, "^": operator.xor}


def as_text(value: Value) -> str:
    """Return a value as the text that ``..`` joins; raise a `ValueError` if it has none."""
    return str(cast(value[0], value[1], STRING))


def join(first: str, second: str) -> str:
    """Join two texts; a result longer than `MAX_TEXT` is a `ScriptError`."""
    if len(first) + len(second) > MAX_TEXT:
        raise ScriptError(f"a text is longer than {MAX_TEXT} characters")
    return first + second


def comparison(first: Expression, rest: list[tuple[str, Expression]]) -> Expression:
    """Compile comparisons, chained ones too: ``1 < x <= 5``."""

    def evaluate(env: Environment) -> Value:
        left = first(env)
        for symbol, operand in rest:
            right = operand(env)
            if not _compare(symbol, left, right, env.enums):
                return 0.0, DOUBLE
            left = right
        return 1.0, DOUBLE

    return evaluate


def _compare(symbol: str, left: Value, right: Value, enums: Mapping[str, int]) -> bool:
    _check_written(symbol, left, right)
    left_family, right_family = left[1].family, right[1].family
    a: Any
    b: Any
    if left_family == right_family == "string":
        a, b = left[0].encode(), right[0].encode()
        same = a == b
    elif "object" in (left_family, right_family):
        raise ScriptError(f"cannot compare {shown(left[0])} with {shown(right[0])}")
    else:
        a = text_as_double(left[0], enums) if left_family == "string" else as_double(left)
        b = text_as_double(right[0], enums) if right_family == "string" else as_double(right)
        same = abs(a - b) <= EPSILON
    if symbol == "==":
        return bool(same)
    if symbol == "!=":
        return not same
    # As negations, so that comparisons with NaN come out as in the engine.
    if symbol == "<":
        return not a >= b
    if symbol == ">":
        return not a <= b
    return not a > b if symbol == "<=" else not a < b


def _check_written(symbol: str, left: Value, right: Value) -> None:
    for side, value in (("left", left), ("right", right)):
        if value[0] is EMPTY:
            raise ScriptError(f"the {side} operand of operator [{symbol}] {missing(value)}")


def ternary(condition: Expression, then: Expression, otherwise: Expression) -> Expression:
    """Compile ``condition ? then : otherwise``."""

    def evaluate(env: Environment) -> Value:
        value = condition(env)
        if value[0] is EMPTY or value[1].family == "object":
            raise ScriptError("the condition before [?] is no number")
        return then(env) if as_double(value) != 0 else otherwise(env)

    return evaluate


def assignment(target: Expression, symbol: str, source: Expression) -> Expression:
    """Compile ``:=`` (create or assign), ``=`` (assign), ``+= -= *= /=``."""

    def evaluate(env: Environment) -> Value:
        if not isinstance(target, Name):
            raise ScriptError(f"the left operand of [{symbol}] is not a blackboard entry")
        key = target.key
        entry = env.scope.entry(key)
        if entry is None:
            if symbol != ":=":
                raise ScriptError(
                    f"the blackboard entry '{shortened(key)}' does not exist; [:=] would create it"
                )
            try:
                env.scope.declare(key)
            except BlackboardError as error:
                raise ScriptError(str(error)) from None
            entry = env.scope.entry(key)
            if entry is None:
                raise ScriptError(
                    f"'{key}' is remapped to an entry of the root that does not exist; "
                    "only its own name, with @, creates it"
                )
        value = source(env)
        if value[0] is EMPTY:
            raise ScriptError(f"the right operand of operator [{symbol}] {missing(value)}")
        try:
            if symbol in (":=", "="):
                _assign(entry, value, env.enums)
            else:
                _update(entry, symbol, value)
        except (ValueError, ScriptError) as error:
            raise ScriptError(
                f"entry '{shortened(key)}' does not take {shown(value[0])}: {error}"
            ) from None
        return entry.value, entry.type

    return evaluate


def _assign(entry: Entry, value: Value, enums: Mapping[str, int]) -> None:
    content, type = value
    current = entry.value
    if current is EMPTY and entry.declared is UNTYPED:
        entry.put(content, type)
    elif type.family == "string" and (current is EMPTY or entry.type.family != "string"):
        convert = entry.declared.converter
        if convert is not None:
            entry.put(convert(content), entry.declared)
        elif current is not EMPTY and entry.type.family in NUMBERS:
            entry.put(text_as_double(content, enums), DOUBLE)
        else:
            raise ScriptError(f"a text does not become a {entry.type.name}")
    else:
        entry.copy_in(content, type)


def _update(entry: Entry, symbol: str, value: Value) -> None:
    if entry.value is EMPTY:
        raise ScriptError(f"the left operand of operator [{symbol}] was never written")
    current = (entry.value, entry.type)
    family = value[1].family
    if family in NUMBERS:
        if current[1].family not in NUMBERS:
            raise ScriptError(f"operator [{symbol}] needs a number on its left")
        entry.copy_in(*calculate(symbol[0], current, value))
    elif family == "string":
        if symbol != "+=":
            raise ScriptError(f"operator [{symbol}] does not take a text")
        entry.copy_in(join(as_text(current), value[0]), STRING)
    else:
        entry.copy_in(*current)
