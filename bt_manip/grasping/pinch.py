"""Two places of an object between which fingers can press, and where the tool is then."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .grasp import GraspTable
from .hand import Hand
from .solid import Solid

DEPTH = 0.010
"""How far under the surface the tool's centre goes where sides are straight [m]."""

SLACK = 1.5e-3  # [m] on each side that the fingers open wider than what they grip
_PALM = 3e-3  # [m] between the palm and what is gripped
_TIPS = (5e-3, 1e-3)  # [m] that the tips end before the far side: better, and at least
_OVERLAP = 4e-3  # [m] of the fingers that lie on straight sides, at least
_BEYOND = 2e-3  # [m] by which the tips reach beyond a single place, at least
_BEFORE = 0.25  # radii before the middle of round sides that the tips may end


class Pinch(NamedTuple):
    """A line through an object along which two fingers press, and a way to come there.

    Attributes:
        middle: Of the two places, in the object's frame [m].  # (3,)
        closing: Direction from one to the other; unit.  # (3,)
        approach: Direction that the tool comes in, across that; unit.  # (3,)
        width: Distance between the two [m].
        straight: How far the same width goes on against the approach, 0 for round sides [m].
        contact: Share of the pads that finds something to lie on, 0 to 1.
        slant: Largest angle between the closing direction and the normal of a face [rad].
        radius: Of round sides, where fingers may press a little before the middle, too [m].
        part: Number of the solid that is gripped; -1 for the whole object.
    """

    middle: np.ndarray
    closing: np.ndarray
    approach: np.ndarray
    width: float
    straight: float = 0.0
    contact: float = 1.0
    slant: float = 0.0
    radius: float = 0.0
    part: int = -1


def grasps_of(pinches: Sequence[Pinch], hand: Hand, solids: Sequence[Solid]) -> GraspTable:
    """Place the hand for each pinch, where palm and tips leave it room.

    Args:
        pinches: Where fingers can press; at least one.
        hand: The hand.
        solids: All of the object.
    """
    middle, closing, approach = (np.array(c) for c in list(zip(*pinches, strict=True))[:3])
    width, straight, contact, slant, radius, part = np.array([pinch[3:] for pinch in pinches]).T
    along = np.einsum("ij,ij->i", approach, middle)
    above = _reach(solids, -approach, part) + along
    below = _reach(solids, approach, part) - along
    liked = np.maximum(straight - DEPTH, 0.0)
    least = np.maximum(liked, above + _PALM - hand.palm)
    better, enough = (np.maximum(least, hand.tip + clear - below) for clear in _TIPS)
    lies = np.where(radius > 0.0, -_BEFORE * radius, _BEYOND)
    most = straight + hand.tip - np.where(straight > 0.0, _OVERLAP, lies)
    back = np.minimum(better, most)
    before = np.clip((back - hand.tip) / np.maximum(radius, 1e-9), 0.0, _BEFORE)
    slant = np.where(radius > 0.0, np.arcsin(before), slant)
    k = np.flatnonzero(enough <= most)
    object_axes = np.stack([closing, np.cross(approach, closing), approach], axis=2)
    z = np.array([0.0, 0.0, 1.0])
    tool_axes = np.stack([hand.closing, np.cross(z, hand.closing), z], axis=1)
    return GraspTable(
        object_axes[k] @ tool_axes.T,
        middle[k] - back[k, None] * approach[k],
        width[k],
        closing[k],
        contact[k],
        slant[k],
        (back - liked)[k],
    )


def _reach(solids: Sequence[Solid], directions: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Give how far the gripped part, or all of the object, reaches in directions [m]."""
    each = np.array([solid.reach(directions) for solid in solids])  # (solids, n)
    whole = each.max(axis=0)
    own = each[np.maximum(part, 0).astype(int), np.arange(len(part))]
    return np.where(part < 0, whole, own)


def fits(width: float, hand: Hand) -> bool:
    """Tell whether fingers open wide enough, and close far enough, for a width [m]."""
    return hand.least + 5e-4 < width <= hand.stroke - 2.0 * SLACK


def across(closing: np.ndarray, down: np.ndarray, turns: Sequence[float]) -> list[np.ndarray]:
    """List directions across a line: the one nearest to straight down, and turned from it.

    Args:
        closing: The line; unit.  # (3,)
        down: Straight down, in the same frame; unit.  # (3,)
        turns: Angles about the line [rad].
    """
    first = down - (down @ closing) * closing
    length = float(np.linalg.norm(first))
    if length < 1e-3:  # the line is upright: any direction across it is as good
        first = np.cross(closing, np.eye(3)[int(np.argmin(np.abs(closing)))])
        length = float(np.linalg.norm(first))
    first = first / length
    second = np.cross(closing, first)
    return [np.cos(t) * first + np.sin(t) * second for t in turns]
