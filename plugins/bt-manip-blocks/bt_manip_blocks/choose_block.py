"""Choose the block to pick next."""

from typing import Any

from bt_manip.behaviours.poses import GRIP_HEIGHT, centre_pose, grips_from_above
from bt_manip.bt import Input, Output, Status, SyncAction
from bt_manip.cell import Cell, CellError
from bt_manip.motion import Arm
from bt_manip.motion.grasping import HandRoom, with_room
from bt_manip_blocks.coloured_block import ColouredBlock


class ChooseBlock(SyncAction):
    """Choose the block that the hand has most room to grip, of those that lie on something."""

    on = Input(str, default="table", doc="Name of what the block has to touch.")
    besides = Input(str, default="", doc="Name of a block that is not to be chosen.")
    block = Output(str, doc="Name of the block.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep cell and arm."""
        self.cell: Cell = infrastructure["cell"]
        self.arm: Arm = infrastructure["arm"]

    def update(self) -> Status:
        """Compare the blocks."""
        cell = self.cell
        try:
            cell.find(self.on)
            blocks = [
                name
                for name, entity in cell.objects.items()
                if isinstance(entity, ColouredBlock)
                and name != self.besides
                and cell.contacts.touching(name, self.on)
            ]
        except CellError as error:
            return self.fail(str(error))
        if not blocks:
            return self.fail(f"no block lies on '{self.on}'")
        room, chosen = max((self._room(name), name) for name in blocks)
        self.block = chosen
        self.feedback_message = f"'{chosen}', with {1000 * room:.0f} mm of room"
        return Status.SUCCESS

    def _room(self, name: str) -> float:
        grips = grips_from_above(centre_pose(self.cell, name), GRIP_HEIGHT)
        return with_room(grips, HandRoom(self.cell, self.arm.robot, [name]))[1].distance
