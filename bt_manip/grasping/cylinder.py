"""Where a cylinder or a capsule can be gripped."""

import math
from collections.abc import Iterator

import numpy as np

from .hand import Hand
from .pinch import Pinch, across, fits
from .solid import Solid

LINE = 0.8  # contact of a pad that lies on a line
POINT = 0.6  # contact of a pad that lies on a point
_YAWS = 8
_ROUND = tuple(2 * math.pi * k / _YAWS for k in range(_YAWS))
_SLOPES = (0.0, math.pi / 4, -math.pi / 4, math.pi / 2, -math.pi / 2)


def cylinder_pinches(solid: Solid, hand: Hand, down: np.ndarray) -> Iterator[Pinch]:
    """List the diameters of a cylinder or a capsule, and its length, where they fit.

    Diameters are come to along the axis, turned by eighths; and across it, from the direction that
    is nearest to straight down and turned from there; along the axis at the middle and beside it.

    Args:
        solid: A cylinder or a capsule.
        hand: The hand.
        down: Straight down, in the object's frame; nothing comes from below.  # (3,)
    """
    axis, middle = solid.T_os.rotation[:, 2], solid.T_os.translation
    radius, half = float(solid.size[0]), float(solid.size[1])
    end = half + (radius if solid.kind == "capsule" else 0.0)
    if fits(2.0 * radius, hand):
        yield from _over_the_end(solid, axis, down)
        room = max(half - hand.pad, 0.0)
        shifts = (0.0, 0.6 * room, -0.6 * room) if room > hand.pad else (0.0,)
        for a in across(axis, down, _ROUND):
            if a @ down >= -0.1:
                for shift in shifts:
                    for closing in (np.cross(axis, a), np.cross(a, axis)):
                        place = middle + shift * axis
                        yield Pinch(place, closing, a, 2.0 * radius, 0.0, LINE, 0.0, radius)
    if fits(2.0 * end, hand):
        contact = min(1.0, radius / hand.pad) if solid.kind == "cylinder" else POINT
        for a in across(axis, down, _SLOPES):
            if a @ down >= -0.1:
                # The ends are as deep as the cylinder is wide there.
                straight = 0.5 * radius if solid.kind == "cylinder" else 0.0
                yield Pinch(middle, axis, a, 2.0 * end, straight, contact)
                yield Pinch(middle, -axis, a, 2.0 * end, straight, contact)


def _over_the_end(solid: Solid, axis: np.ndarray, down: np.ndarray) -> Iterator[Pinch]:
    """List diameters that are come to along the axis."""
    middle, radius, half = solid.T_os.translation, float(solid.size[0]), float(solid.size[1])
    for a in (axis, -axis):
        if a @ down >= -0.1:
            side = solid.T_os.rotation[:, 0]
            other = np.cross(a, side)
            for yaw in _ROUND:
                closing = math.cos(yaw) * side + math.sin(yaw) * other
                yield Pinch(middle, closing, a, 2.0 * radius, half, LINE)
