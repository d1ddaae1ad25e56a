"""Where a box can be gripped."""

from collections.abc import Iterator

import numpy as np

from .hand import Hand
from .pinch import Pinch, fits
from .solid import Solid

_LONG = 3.0  # half lengths in pads from which on a box is gripped beside its middle, too
_EDGE = 0.5  # of the pads that lie on a face when a box is gripped over an edge
_DIAGONAL = np.sqrt(0.5)


def box_pinches(solid: Solid, hand: Hand, down: np.ndarray) -> Iterator[Pinch]:
    """List the pairs of opposite faces that fit between the fingers, and the ways to them.

    Each pair is come to over each of the four other faces, and over the edges between these;
    either finger may come first. Where a box is long, beside its middle too.

    Args:
        solid: A box.
        hand: The hand.
        down: Straight down, in the object's frame; nothing comes from below.  # (3,)
    """
    R, middle, half = solid.T_os.rotation, solid.T_os.translation, solid.size
    for i in range(3):
        width = 2.0 * float(half[i])
        if not fits(width, hand):
            continue
        j, k = (i + 1) % 3, (i + 2) % 3
        for closing in (R[:, i], -R[:, i]):
            for along, other in ((j, k), (k, j)):
                contact = min(1.0, half[other] / hand.pad)
                for a in (R[:, along], -R[:, along]):
                    if a @ down < -0.1:
                        continue
                    straight = float(half[along])
                    yield Pinch(middle, closing, a, width, straight, contact)
                    if half[other] > _LONG * hand.pad:
                        shift = 0.6 * (half[other] - hand.pad) * R[:, other]
                        yield Pinch(middle + shift, closing, a, width, straight, contact)
                        yield Pinch(middle - shift, closing, a, width, straight, contact)
            for sign_j, sign_k in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                a = _DIAGONAL * (sign_j * R[:, j] + sign_k * R[:, k])
                if a @ down >= -0.1:
                    # Over an edge the middle is as deep as the corner is far.
                    straight = _DIAGONAL * float(min(half[j], half[k]))
                    yield Pinch(middle, closing, a, width, straight, _EDGE)
