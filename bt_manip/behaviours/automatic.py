"""Ports that may be ``auto``: the behaviour chooses the value when it starts."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from bt_manip.bt import DOUBLE, DOUBLE_LIST, Input, PortType
from bt_manip.exceptions import MotionError

AUTO = "auto"
"""Text of a port whose value the behaviour chooses; it reads None."""


def _or_auto(type: PortType) -> PortType:
    """Return a port type that also takes ``auto``."""
    parse, format = type.parse, type.format
    assert parse is not None and format is not None
    return replace(
        type,
        parse=lambda text: None if text.strip() in (AUTO, "") else parse(text),
        format=lambda value: AUTO if value is None else format(value),
    )


NUMBER_OR_AUTO = _or_auto(DOUBLE)
NUMBERS_OR_AUTO = _or_auto(DOUBLE_LIST)


def number_or_auto(doc: str) -> Input:
    """Declare an input port for a number, by default ``auto``."""
    return Input(NUMBER_OR_AUTO, default=AUTO, doc=doc)


def numbers_or_auto(doc: str) -> Input:
    """Declare an input port for several numbers, by default ``auto``."""
    return Input(NUMBERS_OR_AUTO, default=AUTO, doc=doc)


def first_reachable(
    height: float | None, heights: Sequence[float], move: Callable[[float], None]
) -> None:
    """Move to the given height, or to the first of several that the arm reaches.

    Args:
        height: The given height [m]; None for the first reachable one.
        heights: Heights to choose from, the preferred one first [m].
        move: Requests the motion to a height.

    Raises:
        MotionError: When it is not feasible: of the last height, if none is reachable.
    """
    *others, last = heights if height is None else (height,)
    for value in others:
        try:
            return move(value)
        except MotionError as error:
            if error.reason != "unreachable":
                raise
    return move(last)
