"""Close the gripper."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class CloseGripper(ArmBehaviour):
    """Close the fingers on whatever is between them, or on each other."""

    force = Input(float, default=50.0, doc="Normal force of each finger [N].")
    patience = Input(float, default=2.0, doc="Longest simulated time to try [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Start to close."""
        self.gripper.close(self.force)

    def update(self) -> Status:
        """Wait until the fingers press steadily or have met."""
        self.feedback_message = f"{1000 * self.gripper.width:.0f} mm open"
        if self.gripper.steady or self.gripper.closed_on_nothing:
            return Status.SUCCESS
        if self.elapsed > self.patience:
            left, right = self.gripper.finger_forces
            return self.fail(
                f"the fingers press with {left:.1f} and {right:.1f} N after {self.patience:g} s, "
                f"asked {self.force:g} N"
            )
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Keep the fingers where they are when halted."""
        if new_status == Status.INVALID:
            self.gripper.stop()
