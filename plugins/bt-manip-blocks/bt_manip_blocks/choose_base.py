"""Choose the block to build a tower on."""

import math

import numpy as np

from bt_manip.behaviours import CellBehaviour
from bt_manip.bt import Input, Output, Status
from bt_manip_blocks.blocks import blocks_on, tower_on


class ChooseBase(CellBehaviour):
    """Choose the block to build a tower on: the base of the highest tower.

    Of several it is the one whose nearest neighbour is farthest away. A tower is as high as the
    hand over a block on the table: what lies beside it can be gripped no longer.
    """

    on = Input(str, default="table", doc="Name of what the block has to touch.")
    base = Output(str, doc="Name of the block.")
    top = Output(str, doc="Name of the highest block of the tower on it; the same without one.")

    def update(self) -> Status:
        """Compare the blocks."""
        places = {b: self.cell.pose(b).translation[:2] for b in blocks_on(self.cell, self.on)}
        if not places:
            return self.fail(f"no block lies on '{self.on}'")
        gaps = {
            name: min(
                (float(np.linalg.norm(p - q)) for o, q in places.items() if o != name),
                default=math.inf,
            )
            for name, p in places.items()
        }
        towers = {name: tower_on(self.cell, name) for name in places}
        self.base = chosen = max(gaps, key=lambda name: (len(towers[name]), gaps[name], name))
        self.top = towers[chosen][-1]
        self.feedback_message = f"'{chosen}', {1000 * gaps[chosen]:.0f} mm from the nearest"
        return Status.SUCCESS
