"""Where a ball can be gripped."""

import math
from collections.abc import Iterator

import numpy as np

from .cylinder import POINT
from .hand import Hand
from .pinch import Pinch, across, fits
from .solid import Solid

_YAWS = 8


def sphere_pinches(solid: Solid, hand: Hand, down: np.ndarray) -> Iterator[Pinch]:
    """List level diameters of a ball, come to from above, from half way down and from the side.

    Args:
        solid: A ball.
        hand: The hand.
        down: Straight down, in the object's frame.  # (3,)
    """
    width = 2.0 * float(solid.size[0])
    if not fits(width, hand):
        return
    upright = down / np.linalg.norm(down)
    for side in across(upright, np.array([1.0, 0.0, 0.0]), _turns()):
        for tilt in (0.0, math.pi / 4, math.pi / 2):
            a = math.cos(tilt) * upright + math.sin(tilt) * np.cross(side, upright)
            yield Pinch(solid.T_os.translation, side, a, width, 0.0, POINT, 0.0, 0.5 * width)


def _turns() -> list[float]:
    return [2 * math.pi * k / _YAWS for k in range(_YAWS)]
