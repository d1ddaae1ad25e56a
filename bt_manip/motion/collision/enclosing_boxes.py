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

    def take(self, rows: np.ndarray) -> "Boxes":
        """Give some of them."""
        return Boxes(self.centre[rows], self.rotation[rows], self.half[rows])


def apart(first: Boxes, second: Boxes, enough: float) -> np.ndarray:
    """Give a lower bound of the distance of boxes [m], negative where they may overlap.

    The larger of the gap along the normal of a face of either, and that between one and the sphere
    around the other. Gaps along the cross products of edges are left out: the bound is a little
    lower for it.

    Args:
        first: On one side.
        second: On the other.
        enough: Where it is more than that, nobody asks by how much [m].
    """  # (n,)
    between = second.centre - first.centre
    beyond = np.abs(_seen_from(second, between)) - second.half
    bound = _outside(beyond) - np.linalg.norm(first.half, axis=-1)
    rows = np.flatnonzero(bound < enough)
    if not len(rows):
        return bound
    one, other = first.take(rows), second.take(rows)
    in_first = np.abs(_seen_from(one, between[rows])) - one.half
    spread = np.abs(np.swapaxes(one.rotation, -1, -2) @ other.rotation)
    closer = np.maximum.reduce([
        (in_first - (spread @ other.half[..., np.newaxis])[..., 0]).max(axis=-1),
        (beyond[rows] - (one.half[..., np.newaxis, :] @ spread)[..., 0, :]).max(axis=-1),
        _outside(in_first) - np.linalg.norm(other.half, axis=-1),
    ])  # fmt: skip
    bound[rows] = np.maximum(bound[rows], closer)
    return bound


def _seen_from(boxes: Boxes, vectors: np.ndarray) -> np.ndarray:
    return (vectors[..., np.newaxis, :] @ boxes.rotation)[..., 0, :]


def _outside(beyond: np.ndarray) -> np.ndarray:
    """Give how far points are from a box, from how far they are beyond its faces."""
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
