"""Search for a slot in the tray."""

import numpy as np

from bt_manip.behaviours import CellBehaviour, pose_output
from bt_manip.bt import Input, Status, Traits
from bt_manip_blocks.blocks import blocks_in, find_tray
from bt_manip_blocks.coloured_block import ColouredBlock
from bt_manip_blocks.sorting_tray import SLOT


class FindSlot(CellBehaviour):
    """Find a free slot in the row of a block's colour."""

    traits = Traits()
    block = Input(str, doc="Name of the block.")
    tray = Input(str, default="tray", doc="Name of the tray.")
    pose = pose_output("Target pose of the centre of the block's bottom in the world.")

    def update(self) -> Status:
        """Search for an empty slot."""
        cell = self.cell
        block, tray = cell.find(self.block), find_tray(cell, self.tray)
        if not isinstance(block, ColouredBlock):
            return self.fail(f"'{self.block}' is not a coloured block")
        slots = [cell.pose(self.tray) * slot for slot in tray.row(block.colour)]
        others = [cell.pose(name).translation for name in blocks_in(cell) if name != self.block]
        for slot in slots:
            if all(np.linalg.norm((p - slot.translation)[:2]) > SLOT / 2 for p in others):
                self.pose = slot
                return Status.SUCCESS
        return self.fail(f"the row for {block.colour} is full")
