"""Check that all blocks stand on one another."""

from itertools import pairwise
from typing import Any

from bt_manip.bt import Condition, Input, Status
from bt_manip.cell import Cell, CellError, why_not_on
from bt_manip_blocks.blocks import blocks_in, blocks_on, tower_on


class AreStacked(Condition):
    """Check that all coloured blocks are one tower: each rests on the one below it, released."""

    on = Input(str, default="table", doc="Name of what the lowest of them stands on.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def update(self) -> Status:
        """Check the contacts of each block."""
        cell = self.cell
        try:
            lowest = blocks_on(cell, self.on)
        except CellError as error:
            return self.fail(str(error))
        if len(lowest) != 1:
            return self.fail(f"{len(lowest)} blocks stand on '{self.on}': {', '.join(lowest)}")
        tower = sorted(blocks_in(cell), key=lambda name: cell.pose(name).translation[2])
        for below, above in pairwise(tower):
            reason = why_not_on(cell, above, below)
            if reason:
                return self.fail(reason)
        return Status.SUCCESS

    def progress(self) -> float:
        """Return the share of the blocks in the highest tower, above its base."""
        towers = [tower_on(self.cell, base) for base in blocks_on(self.cell, self.on)]
        highest = max(map(len, towers), default=1)
        return (highest - 1) / max(len(blocks_in(self.cell)) - 1, 1)
