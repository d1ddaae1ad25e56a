"""Check that all blocks stand on one another."""

from itertools import pairwise
from typing import Any

from bt_manip.bt import Condition, Input, Status
from bt_manip.cell import Cell, CellError
from bt_manip_blocks.blocks import blocks_in, blocks_on


class AreStacked(Condition):
    """Check that all coloured blocks are one tower: each touches the one below it."""

    on = Input(str, default="table", doc="Name of what the lowest of them stands on.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def update(self) -> Status:
        """Look what each of them touches."""
        cell = self.cell
        try:
            lowest = blocks_on(cell, self.on)
        except CellError as error:
            return self.fail(str(error))
        if len(lowest) != 1:
            return self.fail(f"{len(lowest)} blocks stand on '{self.on}': {', '.join(lowest)}")
        tower = sorted(blocks_in(cell), key=lambda name: cell.pose(name).translation[2])
        for below, above in pairwise(tower):
            if not cell.contacts.touching(above, below):
                return self.fail(f"'{above}' does not stand on '{below}'")
        return Status.SUCCESS
