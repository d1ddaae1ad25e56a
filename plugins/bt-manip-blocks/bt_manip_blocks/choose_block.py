"""Choice of the base of a tower and of the next block to pick."""

import math
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm
from bt_manip.behaviours import CellBehaviour, centre_pose, pose_output, top_grasp_poses
from bt_manip.bt import Input, Output, Status, Traits
from bt_manip.grasping import SUFFICIENT_CLEARANCE, GripperClearance, with_clearance
from bt_manip.grippers import GRIP_DEPTH
from bt_manip_blocks.blocks import blocks_on, tower_on


class ChooseBase(CellBehaviour):
    """Choose the base of a tower: the base of the highest one.

    Of several, it is the block with the largest distance to its nearest neighbour. A tower is as
    high as the hand over a block on the table, so blocks close to it can no longer be gripped.
    """

    traits = Traits()
    on = Input(str, default="table", doc="Name of the entity below the block.")
    base = Output(str, doc="Name of the block.")
    top = Output(str, doc="Name of the top block of its tower; without a tower, the block.")

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
    """Choose a block on an object at which the gripper has clearance.

    With a base, it is the block nearest to its tower, before the tower obstructs the gripper;
    otherwise the block with the largest clearance.
    """

    traits = Traits()
    on = Input(str, default="table", doc="Name of the entity below the block.")
    base = Input(str, default="", doc="Name of the base of the tower, which is not chosen.")
    block = Output(str, doc="Name of the block.")
    place = pose_output("Present pose of the centre of its bottom in the world.")

    def setup(self, **infrastructure: Any) -> None:
        """Store the arm, too."""
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
        bottom = T_wo.translation - np.array([0.0, 0.0, block.rest_height])  # on any face
        return pin.SE3(T_wo.rotation, bottom)

    def _gap(self, name: str) -> float:
        at, base = self.cell.pose(name).translation, self.cell.pose(self.base).translation
        return float(np.linalg.norm(at - base))
