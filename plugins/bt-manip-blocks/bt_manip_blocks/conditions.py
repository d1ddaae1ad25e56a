"""Conditions on all blocks of a cell."""

from itertools import pairwise

from bt_manip.behaviours import CellCondition
from bt_manip.bt import Input
from bt_manip.cell import why_not_on
from bt_manip_blocks.blocks import blocks_in, blocks_on, tower_on, unsorted_blocks


class AreSorted(CellCondition):
    """Check that all coloured blocks are released and at rest in the row of their colour."""

    tray = Input(str, default="tray", doc="Name of the tray.")

    def why_not(self) -> str:
        """Compare their positions with the rows."""
        left = unsorted_blocks(self.cell, self.tray)
        return f"not in the row of their colour: {', '.join(left)}" if left else ""

    def progress(self) -> float:
        """Return the share of the blocks that are sorted."""
        return 1.0 - len(unsorted_blocks(self.cell, self.tray)) / len(blocks_in(self.cell))


class AreStacked(CellCondition):
    """Check that all coloured blocks form one tower, released and at rest."""

    on = Input(str, default="table", doc="Name of the support of the tower.")

    def why_not(self) -> str:
        """Check the contacts of each block."""
        cell = self.cell
        lowest = blocks_on(cell, self.on)
        if len(lowest) != 1:
            return f"{len(lowest)} blocks stand on '{self.on}': {', '.join(lowest)}"
        tower = sorted(blocks_in(cell), key=lambda name: cell.pose(name).translation[2])
        reasons = (why_not_on(cell, above, below) for below, above in pairwise(tower))
        return next(filter(None, reasons), "")

    def progress(self) -> float:
        """Return the share of the blocks in the highest tower, above its base."""
        towers = [tower_on(self.cell, base) for base in blocks_on(self.cell, self.on)]
        highest = max(map(len, towers), default=1)
        return (highest - 1) / max(len(blocks_in(self.cell)) - 1, 1)
