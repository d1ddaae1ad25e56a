"""Parameters as text: ``KEY=VALUE KEY=VALUE ...``."""

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from bt_manip.exceptions import BtManipError, did_you_mean

TRUTH = {"yes": True, "no": False}


def parse_key_values(
    words: Iterable[str],
    defaults: Mapping[str, Any],
    owner: str,
    error: type[BtManipError] = BtManipError,
) -> dict[str, Any]:
    """Return the given parameters, each as a value of the type of its default.

    Args:
        words: Each ``KEY=VALUE``; a truth value is ``yes`` or ``no``.
        defaults: All parameters that there are, with their defaults.
        owner: What has the parameters, for messages.
        error: Class of the error.

    Raises:
        BtManipError: If a parameter is unknown, given twice, or no value of its type. Numbers must
            not be negative, and only a ``duration`` may be infinite.
    """
    values: dict[str, Any] = {}
    for word in words:
        key, equals, value = word.partition("=")
        if not equals or key in values:
            problem = "is given twice" if equals else "is not KEY=VALUE"
            raise error(f"{owner}: '{word}' {problem}")
        if key not in defaults:
            raise error(f"{owner} has no parameter '{key}'{did_you_mean(key, defaults)}")
        kind = type(defaults[key])
        number = _value(kind, value)
        if number is None or (number == math.inf and key != "duration"):
            kinds = {int: "a whole number of at least 0", bool: "yes or no"}
            what = kinds.get(kind, "a number of at least 0")
            raise error(f"{owner}: {key} is {what}, got '{value}'")
        values[key] = number
    return values


def keyword_defaults(factory: Callable[..., Any]) -> dict[str, Any]:
    """Return the keyword-only parameters of a factory with their defaults."""
    parameters = inspect.signature(factory).parameters.values()
    return {one.name: one.default for one in parameters if one.kind is one.KEYWORD_ONLY}


def _value(kind: type, text: str) -> Any:
    """Return a text as a value of a type; None if it is none, or negative."""
    if kind is str:
        return text
    if kind is bool:
        return TRUTH.get(text)
    try:
        value = kind(text)
    except ValueError:
        return None
    return value if value >= 0 else None
