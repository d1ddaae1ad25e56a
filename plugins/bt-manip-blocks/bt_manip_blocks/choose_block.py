"""Choose the block to build a tower on, and the one to pick next."""

import math
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm
from bt_manip.behaviours import CellBehaviour, centre_pose, pose_output, top_grasp_poses
from bt_manip.bt import Input, Output, Status
from bt_manip.grasping import SUFFICIENT_CLEARANCE, GripperClearance, with_clearance
from bt_manip.grippers import GRIP_DEPTH
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


class ChooseBlock(CellBehaviour):
    """Choose a block that the gripper has clearance at, of those that lie on an object.

    With a base, the block nearest to the tower on it, before the tower obstructs the gripper there;
    otherwise the one with the largest clearance.
    """

    on = Input(str, default="table", doc="Name of what the block has to touch.")
    base = Input(str, default="", doc="Name of the block that a tower grows on, not to be chosen.")
    block = Output(str, doc="Name of the block.")
    place = pose_output("Where the middle of its bottom is now, in the world.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the arm too."""
        super().setup(**infrastructure)
        self.arm: Arm = infrastructure["arm"]

    def update(self) -> Status:
        """Compare the blocks."""
        around = GripperClearance(self.cell, self.arm.robot, [])
        clearances = {
            block: self._clearance(block, around)
            for block in blocks_on(self.cell, self.on)
            if block != self.base
        }
        gaps = {block: self._gap(block) for block in clearances} if self.base else {}
        if not clearances:
            return self.fail(f"no block lies on '{self.on}'")
        free = [block for block in gaps if clearances[block] >= SUFFICIENT_CLEARANCE]
        if free:
            chosen = min(free, key=lambda block: (gaps[block], block))
        else:
            chosen = max(clearances, key=lambda block: (clearances[block], block))
        self.block, self.place = chosen, self._place(chosen)
        self.feedback_message = f"'{chosen}', with {1000 * clearances[chosen]:.0f} mm of clearance"
        return Status.SUCCESS

    def _clearance(self, name: str, around: GripperClearance) -> float:
        height = self.cell.find(name).rest_height - GRIP_DEPTH
        grips = top_grasp_poses(centre_pose(self.cell, name), height)
        around.ignore([name])
        return with_clearance(grips, around)[1].distance

    def _place(self, name: str) -> pin.SE3:
        T_wo, block = self.cell.pose(name), self.cell.find(name)
        bottom = T_wo.translation - np.array([0.0, 0.0, block.rest_height])  # on whichever face
        return pin.SE3(T_wo.rotation, bottom)

    def _gap(self, name: str) -> float:
        offset = self.cell.pose(name).translation - self.cell.pose(self.base).translation
        return float(np.linalg.norm(offset[:2]))
