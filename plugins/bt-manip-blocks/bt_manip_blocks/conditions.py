"""Conditions on all blocks of a cell."""

from itertools import pairwise
from typing import Any

from bt_manip.behaviours import CellCondition
from bt_manip.bt import Input
from bt_manip.cell import why_not_on
from bt_manip_blocks.blocks import blocks_in, blocks_on, tower_on, unsorted_blocks


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
        left = unsorted_blocks(self.cell, self.tray)
        return f"not in the row of their colour: {', '.join(left)}" if left else ""

    def progress(self) -> float:
        """Return the share of the blocks that are sorted."""
        gone, present = len(self.gone), len(blocks_in(self.cell))
        wrong = len(unsorted_blocks(self.cell, self.tray))
        return 1.0 - (wrong + gone) / max(present + gone, 1)


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

    def progress(self) -> float:
        """Return the share of the blocks in the highest tower, above its base."""
        towers = [tower_on(self.cell, base) for base in blocks_on(self.cell, self.on)]
        highest = max(map(len, towers), default=1)
        return (highest - 1) / max(len(blocks_in(self.cell)) + len(self.gone) - 1, 1)
