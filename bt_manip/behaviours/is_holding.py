"""Check that the gripper holds an object."""

from typing import Any

from bt_manip.bt import Condition, Input, Status
from bt_manip.control import GripperController


class IsHolding(Condition):
    """Check that both fingers press an object."""

    object = Input(str, doc="Name of the object.")

    def setup(self, *, gripper: GripperController, **_: Any) -> None:
        """Keep the gripper."""
        self.gripper = gripper

    def update(self) -> Status:
        """Look at what touches both fingers."""
        held = self.gripper.held
        if self.object in held:
            return Status.SUCCESS
        return self.fail(f"the fingers hold {', '.join(held) or 'nothing'}, not '{self.object}'")
