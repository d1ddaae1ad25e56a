"""Conditions on all blocks of a cell."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import CellCondition, Destination
from bt_manip.bt import Input
from bt_manip.cell import Cell, extent, is_on, why_not_on
from bt_manip_blocks.blocks import blocks_in, blocks_on, find_tray, tower_on

MARGIN = 0.01
"""Distance of a block from the middle of the one below at which it stands well [m]."""


class BlocksCondition(CellCondition):
    """A condition on all coloured blocks: those present, and those that were removed one by one.

    When no block is left, as after the removal of all, the removed ones no longer count.
    """

    memory = ("_gone",)

    _gone: tuple[str, ...] = ()  # names of removed blocks

    def setup(self, **infrastructure: Any) -> None:
        """Observe removals."""
        super().setup(**infrastructure)
        if self._note_removal not in self.cell.before_remove:
            self.cell.before_remove.append(self._note_removal)

    def _note_removal(self, name: str) -> None:
        blocks = blocks_in(self.cell).keys()
        if name in blocks:
            self._gone = (*self.gone, name) if len(blocks) > 1 else ()

    @property
    def gone(self) -> tuple[str, ...]:
        """Names of the blocks that were removed, and are not in the cell again."""
        return tuple(name for name in self._gone if name not in self.cell.entities)

    def why_incomplete(self) -> str:
        """Return which blocks are gone, or that there is none; empty if all are there."""
        if self.gone:
            return f"gone from the cell: {', '.join(self.gone)}"
        return "" if blocks_in(self.cell) else "the cell has no coloured blocks"


class AreSorted(BlocksCondition):
    """Check that all coloured blocks are released and at rest in the row of their colour."""

    tray = Input(str, default="tray", doc="Name of the tray.")

    def why_not(self) -> str:
        """Compare their positions with the rows."""
        if reason := self.why_incomplete():
            return reason
        cell, tray = self.cell, find_tray(self.cell, self.tray)
        T_tw = cell.pose(self.tray).inverse()
        left = [
            name
            for name, block in blocks_in(cell).items()
            if not is_on(cell, name, self.tray)
            or tray.row_at(T_tw.act(cell.pose(name).translation)) != block.colour
        ]
        return f"not in the row of their colour: {', '.join(left)}" if left else ""

    def places(self) -> Mapping[str, Destination | None]:
        """Return the row of its colour for each block; None for those that are gone."""
        tray, T_wt = find_tray(self.cell, self.tray), self.cell.pose(self.tray)
        rows = {colour: Destination(T_wt, *tray.row_box(colour)) for colour in tray.colours}
        blocks = blocks_in(self.cell).items()
        return dict.fromkeys(self.gone) | {name: rows.get(one.colour) for name, one in blocks}


class AreStacked(BlocksCondition):
    """Check that all coloured blocks form one tower, released and at rest."""

    on = Input(str, default="table", doc="Name of the support of the tower.")

    def why_not(self) -> str:
        """Check the contacts of each block."""
        cell = self.cell
        if reason := self.why_incomplete():
            return reason
        lowest = blocks_on(cell, self.on)
        if len(lowest) != 1:
            return f"{len(lowest)} blocks stand on '{self.on}': {', '.join(lowest)}"
        tower = sorted(blocks_in(cell), key=lambda name: cell.pose(name).translation[2])
        reasons = (why_not_on(cell, above, below) for below, above in pairwise((self.on, *tower)))
        return next(filter(None, reasons), "")

    def places(self) -> Mapping[str, Destination | None]:
        """Return where each block is to stand; None for those that are gone.

        Blocks of the highest tower stand where they are, others belong on its top, or on any of
        several of the same height.
        """
        cell, blocks = self.cell, blocks_in(self.cell)
        towers = [tower_on(cell, base) for base in blocks_on(cell, self.on)]
        height = max(map(len, towers), default=0)
        highest = [tower for tower in towers if len(tower) == height]
        tops = {tower[-1]: _top(cell, tower[-1]) for tower in highest}
        standing = {name for tower in highest for name in tower if height > 1}
        places: dict[str, Destination | None] = dict.fromkeys(self.gone)
        for name, block in blocks.items():
            own = _top(cell, name) - [0.0, 0.0, block.size]
            others = [top for below, top in tops.items() if below != name]
            middle = np.array([own] if name in standing or not others else others)
            margin = np.array([MARGIN, MARGIN, 0.0])
            places[name] = Destination(pin.SE3.Identity(), middle - margin, middle + margin)
        return places


def _top(cell: Cell, name: str) -> np.ndarray:
    """Return the middle of a block's top [m]."""  # (3,)
    lower, upper = extent(cell, name)
    return np.array([*(0.5 * (lower + upper))[:2], upper[2]])
