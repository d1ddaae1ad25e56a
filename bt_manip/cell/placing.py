"""Finding a free place for something."""

import numpy as np
import pinocchio as pin

from bt_manip.cell.exceptions import CellError
from bt_manip.cell.probe import Probe
from bt_manip.cell.region import Region

CLEAR = 1e-4
"""Deepest overlap with anything else at a place that counts as free [m]."""


def find_place(
    probe: Probe,
    region: Region,
    rng: np.random.Generator,
    *,
    first: pin.SE3,
    attempts: int,
    drop: bool,
) -> pin.SE3:
    """Draw poses from a region until one is free.

    Args:
        probe: The cell with the thing in it.
        region: Where to look.
        rng: What the poses are drawn from.
        first: The pose to try first.
        attempts: How many poses to try.
        drop: Whether the thing falls from there, and shall come to rest in the region.

    Raises:
        CellError: When none of the attempts has found a place; with the reason of the last one.
    """
    T_wo = first
    for attempt in range(attempts):
        if attempt:
            T_wo = region.sample(rng)
        overlap = probe.overlap(T_wo)
        if overlap is not None and overlap.depth > CLEAR:
            reason = f"it would be {overlap}"
            continue
        if not drop:
            return T_wo
        rested = probe.drop()
        if rested is None:
            reason = "it does not come to rest"
        elif not region.covers(rested):
            reason = "it does not stay in the region"
        else:
            return rested
    raise CellError(f"no free place in {attempts} attempts; in the last, {reason}")
