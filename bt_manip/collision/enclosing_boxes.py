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


def apart(first: Boxes, second: Boxes, enough: np.ndarray) -> np.ndarray:
    """Give a lower bound of the distance of boxes [m], negative where they may overlap.

    The larger of the gap along the normal of a face of either, and that between one and the sphere
    around the other. Gaps along the cross products of edges are left out: the bound is a little
    lower for it.

    Args:
        first: On one side.
        second: On the other.
        enough: Where it is more than that, nobody asks by how much [m].  # (n,)
    """  # (n,)
    between = second.centre - first.centre
    in_first = np.abs(_seen_from(first, between)) - first.half
    in_second = np.abs(_seen_from(second, between)) - second.half
    bound = np.maximum(
        _outside(in_first) - _length(second.half), _outside(in_second) - _length(first.half)
    )
    rows = np.flatnonzero(bound < enough)
    spread = np.abs(np.swapaxes(first.rotation[rows], -1, -2) @ second.rotation[rows])
    along_first = in_first[rows] - (spread @ second.half[rows, :, np.newaxis])[..., 0]
    along_second = in_second[rows] - (first.half[rows, np.newaxis] @ spread)[:, 0]
    gaps = np.maximum(along_first.max(axis=-1), along_second.max(axis=-1))
    bound[rows] = np.maximum(bound[rows], gaps)
    return bound


def _seen_from(boxes: Boxes, vectors: np.ndarray) -> np.ndarray:
    return (vectors[..., np.newaxis, :] @ boxes.rotation)[..., 0, :]


def _outside(beyond: np.ndarray) -> np.ndarray:
    """Give how far points are from a box, from how far they are beyond its faces."""
    return _length(np.maximum(beyond, 0.0))


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
