"""Boxes around geoms: how far these are apart at least."""

from typing import NamedTuple

import numpy as np


class Boxes(NamedTuple):
    """Boxes, each somewhere.

    Attributes:
        centre: Middles [m].  # (n, 3)
        rotation: Their axes, as columns.  # (n, 3, 3)
        half: Half their sizes [m].  # (n, 3)
    """

    centre: np.ndarray
    rotation: np.ndarray
    half: np.ndarray


def apart(first: Boxes, second: Boxes) -> np.ndarray:
    """Give a lower bound of the distance of boxes [m], negative where they may overlap.

    The larger of the gap along the normal of a face of either, and that between one and the sphere
    around the other. Gaps along the cross products of edges are left out: the bound is a little
    lower for it.

    Args:
        first: On one side.
        second: On the other.
    """  # (n,)
    between = second.centre - first.centre
    in_first = np.abs(_seen_from(first, between)) - first.half
    in_second = np.abs(_seen_from(second, between)) - second.half
    spread = np.abs(np.swapaxes(first.rotation, -1, -2) @ second.rotation)
    return np.maximum.reduce([
        (in_first - (spread @ second.half[..., np.newaxis])[..., 0]).max(axis=-1),
        (in_second - (first.half[..., np.newaxis, :] @ spread)[..., 0, :]).max(axis=-1),
        _outside(in_first) - np.linalg.norm(second.half, axis=-1),
        _outside(in_second) - np.linalg.norm(first.half, axis=-1),
    ])  # fmt: skip


def _seen_from(boxes: Boxes, vectors: np.ndarray) -> np.ndarray:
    return (vectors[..., np.newaxis, :] @ boxes.rotation)[..., 0, :]


def _outside(beyond: np.ndarray) -> np.ndarray:
    """Give how far points are from a box, from how far they are beyond its faces."""
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
