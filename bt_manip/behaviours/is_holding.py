"""Check that the gripper holds an object."""

from typing import Any

from bt_manip.bt import Condition, Input, Status
from bt_manip.control import GripperController


class IsHolding(Condition):
    """Check that both fingers press an object."""

    object = Input(str, doc="Name of the object.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the gripper."""
        self.gripper: GripperController = infrastructure["gripper"]

    def update(self) -> Status:
        """Look at what touches both fingers."""
        held = self.gripper.held
        if self.object in held:
            return Status.SUCCESS
        return self.fail(f"the fingers hold {', '.join(held) or 'nothing'}, not '{self.object}'")
