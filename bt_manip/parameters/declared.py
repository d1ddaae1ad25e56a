"""Parameters of functions and dataclasses, and their values given as texts."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from bt_manip.exceptions import BtManipError, did_you_mean

from .parameter import Parameter


def parameters_of(
    declaring: Callable[..., Any], *, keyword_only: bool = False
) -> dict[str, Parameter]:
    """Return the arguments of a function or a class that can be given by name, as declared.

    An argument is declared by its annotation, ``fps: Annotated[float, Parameter("Frames per
    second", above=0.0)] = 25.0``, and a field of a dataclass also by its metadata, of any key.
    Otherwise its type is that of its annotation or default.

    Args:
        declaring: The function or class.
        keyword_only: Whether to return keyword-only arguments alone.
    """
    try:
        signature = inspect.signature(declaring, eval_str=True)
    except Exception:  # an annotation names what only type checkers see
        signature = inspect.signature(declaring)
    kinds = (inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    fields = getattr(declaring, "__dataclass_fields__", {})
    found = {}
    for name, argument in signature.parameters.items():
        if argument.kind in kinds[: 1 if keyword_only else 2]:
            hint = argument.annotation
            notes = [*getattr(hint, "__metadata__", ())]
            notes += fields[name].metadata.values() if name in fields else ()
            declared = next((one for one in notes if isinstance(one, Parameter)), Parameter())
            hint = getattr(hint, "__origin__", hint)
            kind = hint if hint in (bool, int, float, str) else declared.type
            found[name] = replace(declared, name=name, type=kind, default=argument.default)
    return found


def read_words(
    words: Iterable[str],
    parameters: Mapping[str, Parameter],
    owner: str,
    error: type[BtManipError] = BtManipError,
) -> dict[str, Any]:
    """Return the values of parameters that are given as words ``KEY=VALUE``.

    Args:
        words: The words; truth values are ``true`` or ``false``, ``yes`` or ``no``, 1 or 0.
        parameters: All parameters that there are, by name.
        owner: Owner of the parameters, for messages.
        error: Class of the error.

    Raises:
        BtManipError: If a parameter is unknown, given twice, or invalid.
    """
    values: dict[str, Any] = {}
    for word in words:
        key, equals, text = word.partition("=")
        if not equals or key in values:
            problem = "is given twice" if equals else "is not KEY=VALUE"
            raise error(f"{owner}: '{word}' {problem}")
        if key not in parameters:
            raise error(f"{owner} has no parameter '{key}'{did_you_mean(key, parameters)}")
        try:
            values[key] = parameters[key].read(text)
        except ValueError as problem:
            raise error(f"{owner}: {key} {problem}") from None
    return values
