"""Texts of a tree document as values, by the rules of the engine's string conversions.

The engine reads numbers with C++'s ``std::from_chars``: the longest number at the very start of
the text counts, and the rest is ignored (``"12abc"`` is 12), while a leading space or plus
sign is an error.
"""

import json
import math
import re
from typing import Any

from bt_manip.bt.status import NodeStatus
from bt_manip.exceptions import shortened, shown

_INTEGER = re.compile(r"-?[0-9]+")
_REAL = re.compile(
    r"-?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?:inity)?|nan(?:\(\w*\))?)",
    re.IGNORECASE,
)
_BOOLEANS = {
    **dict.fromkeys(("1", "true", "True", "TRUE"), True),
    **dict.fromkeys(("0", "false", "False", "FALSE"), False),
}


def parse_integer(text: str, bits: int = 32, *, signed: bool = True) -> int:
    """Read the integer at the start of a text, for an integer type of that width.

    Raises:
        ValueError: If there is none, or if it does not fit.
    """
    match = _INTEGER.match(text)
    if match is None:
        raise ValueError(f"{shown(text)} is not an integer")
    value = int(match[0])
    lower, upper = integer_range(bits, signed=signed)
    if not lower <= value <= upper:
        raise ValueError(f"{shown(value)} is outside {lower} .. {upper}")
    return value


def integer_range(bits: int, *, signed: bool) -> tuple[int, int]:
    """Return the smallest and the largest number of an integer type."""
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)


def parse_real(text: str, *, whole: bool = False) -> float:
    """Read the floating point number at the start of a text, which with `whole` ends there.

    Raises:
        ValueError: If there is none, or if it is too large or too small for a double.
    """
    match = _REAL.match(text)
    if match is None or (whole and match.end() != len(text)):
        raise ValueError(f"{shown(text)} is not a number")
    digits = match[0].lower()
    if "n" in digits:  # inf and nan
        return float(digits.partition("(")[0])
    value = float(digits)
    if math.isinf(value) or (value == 0 and re.search("[1-9]", digits.partition("e")[0])):
        raise ValueError(f"{shortened(match[0])} does not fit a double")
    return value


def rest_after_number(text: str, *, integer: bool) -> str:
    """Return the text after the number at the start, which is ignored; empty without a number."""
    match = (_INTEGER if integer else _REAL).match(text)
    return "" if match is None else text[match.end() :]


def parse_boolean(text: str) -> bool:
    """Read ``0 1 true True TRUE false False FALSE``; anything else is a `ValueError`."""
    try:
        return _BOOLEANS[text]
    except KeyError:
        raise ValueError(f"{shown(text)} is not a truth value (true, false, 1 or 0)") from None


def parse_status(text: str) -> NodeStatus:
    """Read the name of a node status; anything else is a `ValueError`."""
    try:
        return NodeStatus[text]
    except KeyError:
        names = ", ".join(NodeStatus.__members__)
        raise ValueError(f"{shown(text)} is not a status ({names})") from None


def split_list(text: str) -> list[str]:
    """Split a text at its semicolons; no item follows a semicolon at the very end."""
    if not text:
        return []
    parts = text.split(";")
    return parts[:-1] if parts[-1] == "" else parts


def parse_json(text: str) -> Any:
    """Read the JSON text after the ``json:`` of a literal; anything else is a `ValueError`."""
    try:
        return json.loads(text, parse_constant=_no_constant, parse_float=_finite)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{shown(text)} is not JSON ({error})") from None


def _no_constant(text: str) -> Any:
    raise ValueError(f"{text} is not in JSON")


def _finite(text: str) -> float:
    value = float(text)
    if math.isinf(value):
        raise ValueError(f"{shortened(text)} does not fit a double")
    return value


def to_string(value: int | float) -> str:
    """Write a number as the engine does when it needs a string: C++'s ``std::to_string``."""
    return f"{value:f}" if isinstance(value, float) else str(int(value))
