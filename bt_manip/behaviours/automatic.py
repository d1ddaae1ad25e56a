"""Ports that may be ``auto``: the behaviour chooses the value when it starts."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bt_manip.arm import Arm
from bt_manip.bt import DOUBLE, DOUBLE_LIST, Input, PortType
from bt_manip.exceptions import MotionError

AUTO = "auto"
"""Text of a port whose value the behaviour chooses; it reads None."""

EXERTED_PART = 0.8
"""Part of the force that an arm or a grip exerts which ``auto`` uses."""


def _or_auto(type: PortType) -> PortType:
    """Return a port type that also takes ``auto``."""
    parse, format = type.parse, type.format
    assert parse is not None and format is not None
    return replace(
        type,
        parse=lambda text: None if text.strip() in (AUTO, "") else parse(text),
        format=lambda value: AUTO if value is None else format(value),
    )


def number_or_auto(doc: str, **declared: Any) -> Input:
    """Declare an input port for a number, by default ``auto``; unit and bounds as of `Input`."""
    return Input(_or_auto(DOUBLE), default=AUTO, doc=doc, **declared)


def numbers_or_auto(doc: str) -> Input:
    """Declare an input port for several numbers, by default ``auto``."""
    return Input(_or_auto(DOUBLE_LIST), default=AUTO, doc=doc)


def feasible_force(
    preferred: float, arm: Arm, direction: np.ndarray, held: float = np.inf
) -> float:
    """Return a force, or 0.8 of the largest that an arm and its grip exert, if that is lower [N].

    Args:
        preferred: The force of arms that are strong enough [N].
        arm: The arm, where it is now.
        direction: Of the force on the surroundings, in world axes; unit.  # (3,)
        held: Largest force that the grip transmits [N], as `bt_manip.grasping.holding_force`.
    """
    exerted = arm.model.static_force(arm.robot.q, direction)
    return min(preferred, EXERTED_PART * min(exerted, held))


def first_reachable(heights: Sequence[float], move: Callable[[float], None]) -> None:
    """Move to the first of several heights that the arm reaches.

    Args:
        heights: Heights to choose from, the preferred one first [m].
        move: Requests the motion to a height.

    Raises:
        MotionError: When it is not feasible: of the last height, if none is reachable.
    """
    *others, last = heights
    for value in others:
        try:
            return move(value)
        except MotionError as error:
            if error.reason != "unreachable":
                raise
    return move(last)
