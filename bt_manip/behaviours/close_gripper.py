"""Close the gripper."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class CloseGripper(ArmBehaviour):
    """Close the gripper, with or without an object in it."""

    needs_gripper = True

    force = Input(float, default=50.0, doc="Gripping force at each contact [N].")
    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Start to close."""
        self.gripper.close(self.force)

    def update(self) -> Status:
        """Wait until the gripper holds steadily or has closed on nothing."""
        self.feedback_message = self.gripper.status
        if self.gripper.steady or self.gripper.closed_on_nothing:
            return Status.SUCCESS
        if self.elapsed > self.patience:
            return self.fail(
                f"no steady grip after {self.patience:g} s: {self.gripper.status}, "
                f"commanded {self.force:g} N"
            )
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop closing when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()
