"""Ports with the value ``auto``, which is chosen at the start of the behaviour."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bt_manip.arm import Arm
from bt_manip.bt import DOUBLE, DOUBLE_LIST, Input, PortType
from bt_manip.exceptions import MotionError

AUTO = "auto"
"""Text of a port whose value is chosen automatically; it reads as None."""

EXERTED_PART = 0.8
"""Fraction of the largest force of an arm or a grip used by ``auto``."""


def _or_auto(type: PortType) -> PortType:
    """Return a port type that also accepts ``auto``."""
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
    """Return the preferred force, or 0.8 of the largest force of arm and grip if lower [N].

    Args:
        preferred: Preferred force [N].
        arm: The arm at its present configuration.
        direction: Direction of the force on the environment, in world axes; unit.  # (3,)
        held: Largest force transmitted by the grip [N], see `bt_manip.grasping.holding_force`.
    """
    exerted = arm.model.static_force(arm.robot.q, direction)
    return min(preferred, EXERTED_PART * min(exerted, held))


def first_reachable(heights: Sequence[float], move: Callable[[float], None]) -> None:
    """Move to the first reachable one of several heights.

    Args:
        heights: Heights, the preferred one first [m].
        move: Requests the motion to a height.

    Raises:
        MotionError: If the motion is not feasible; if no height is reachable, for the last one.
    """
    *others, last = heights
    for value in others:
        try:
            return move(value)
        except MotionError as error:
            if error.reason != "unreachable":
                raise
    return move(last)
