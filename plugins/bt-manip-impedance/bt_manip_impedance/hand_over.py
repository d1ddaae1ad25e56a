"""Hand an object over from one robot to another."""

from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import (
    ArmBehaviour,
    ObjectCondition,
    nearest_orientation,
    pose_from_text,
    pose_to_text,
)
from bt_manip.bt import Input, Output, Status
from bt_manip.cell import CellError, ContactEvent, entity_of, extent


class FindFreeEnd(ArmBehaviour):
    """Find the tool pose from which a robot takes the free end of an object that another one holds.

    The end is that of the object's longest axis that is farther from the tool that holds it. The
    tool points along this axis, and its fingers close along the narrower one of the other axes.
    """

    needs_gripper = True

    object = Input(str, doc="Name of the object.")
    inset = Input(float, default=0.01, doc="Distance of the grasp from the end [m].")
    distance = Input(float, default=0.1, doc="Distance of the pose from the grasp [m].")
    pose = Output(
        pin.SE3, parse=pose_from_text, format=pose_to_text,
        doc="Pose of the tool before the grasp, in the world.",
    )  # fmt: skip

    amounts = {"inset": "m", "distance": "m"}

    def start(self) -> None:
        """Compare the ends of the object."""
        cell, name = self.cell, self.object
        T_wo = cell.pose(name)
        lower, upper = extent(cell, name, T_wo)
        narrow, _, along = np.argsort(upper - lower, kind="stable")
        holder = T_wo.actInv(self._holder(name))[along]
        towards, side, grasp = np.zeros(3), np.zeros(3), 0.5 * (lower + upper)
        towards[along] = 1.0 if abs(lower[along] - holder) > abs(upper[along] - holder) else -1.0
        side[narrow] = 1.0
        end = lower[along] if towards[along] > 0.0 else upper[along]
        grasp[along] = end + (self.inset - self.distance) * towards[along]
        poses = []
        for y in (side, -side):
            R = np.column_stack((np.cross(y, towards), y, towards))
            poses.append(T_wo * pin.SE3(R, grasp))
        self.pose = nearest_orientation(poses, self.T_wt)

    def _holder(self, name: str) -> np.ndarray:
        """Return the position of the tool that holds an object, in the world [m]."""  # (3,)
        for robot in self._robots.values():
            if robot.gripper is not None and name in robot.gripper.held:
                return np.array(robot.arm.model.pose(robot.robot.q).translation)
        raise CellError(f"no robot holds '{name}'")

    def update(self) -> Status:
        """Succeed: the pose is written."""
        return Status.SUCCESS


class IsHandedOver(ObjectCondition):
    """Check that one robot has handed an object over to another one, in the air.

    It is judged from contacts: it holds from the moment at which both robots touch the object and
    the support does not, until the support touches it again.
    """

    memory = ("_handed_over",)

    giver = Input(str, doc="Name of the robot that hands it over.")
    receiver = Input(str, doc="Name of the robot that takes it.")
    support = Input(str, default="table", doc="Name of what it must not be put down on.")

    _handed_over = False

    def setup(self, **infrastructure: Any) -> None:
        """Observe the contacts of the cell."""
        super().setup(**infrastructure)
        self.cell.contact_changed.append(self._observe)

    def _observe(self, event: ContactEvent) -> None:
        name, giver, receiver, support = self._names()
        pair = {entity_of(event.first), entity_of(event.second)}
        known = self.cell.entities.keys() >= {name, giver, receiver, support}
        if not (event.begins and known and name in pair):
            return
        touching = self.cell.contacts.touching
        if touching(name, support):
            self._handed_over = False
        elif touching(name, giver) and touching(name, receiver):
            self._handed_over = True

    def _names(self) -> tuple[str, str, str, str]:
        return self.object, self.giver, self.receiver, self.support

    def why_not(self) -> str:
        """Return the conditions that the contacts have not shown."""
        for name in self._names():
            self.cell.find(name)
        if self._handed_over:
            return ""
        return (
            f"'{self.giver}' has not handed '{self.object}' over to '{self.receiver}' without "
            f"putting it down on '{self.support}'"
        )
