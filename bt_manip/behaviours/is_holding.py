"""Check that the gripper holds an object."""

from bt_manip.bt import Input, Status

from .robot_port import RobotCondition


class IsHolding(RobotCondition):
    """Check that the gripper holds an object."""

    needs_gripper = True

    object = Input(str, doc="Name of the object.")

    def update(self) -> Status:
        """Check what the gripper holds."""
        held = self.gripper.held
        if self.object in held:
            return Status.SUCCESS
        return self.fail(f"the gripper holds {', '.join(held) or 'nothing'}, not '{self.object}'")
