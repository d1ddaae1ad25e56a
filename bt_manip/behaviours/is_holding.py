"""Check that the gripper holds an object."""

from bt_manip.bt import Input, Status

from .robot_port import RobotCondition


class IsHolding(RobotCondition):
    """Check that both fingers press an object."""

    object = Input(str, doc="Name of the object.")

    def update(self) -> Status:
        """Look at what touches both fingers."""
        held = self.gripper.held
        if self.object in held:
            return Status.SUCCESS
        return self.fail(f"the fingers hold {', '.join(held) or 'nothing'}, not '{self.object}'")
