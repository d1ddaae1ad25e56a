"""Check that all blocks are put away."""

from typing import Any

from bt_manip.bt import Condition, Input, Status
from bt_manip.cell import Cell, CellError
from bt_manip_blocks.blocks import blocks_in, unsorted_blocks


class AreSorted(Condition):
    """Check that every coloured block rests on the tray, released, in the row of its colour."""

    tray = Input(str, default="tray", doc="Name of the tray.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def update(self) -> Status:
        """Look where they stand."""
        try:
            left = unsorted_blocks(self.cell, self.tray)
        except CellError as error:
            return self.fail(str(error))
        if left:
            return self.fail(f"not in the row of their colour: {', '.join(left)}")
        return Status.SUCCESS

    def progress(self) -> float:
        """Return the share of the blocks that are sorted."""
        return 1.0 - len(unsorted_blocks(self.cell, self.tray)) / len(blocks_in(self.cell))
