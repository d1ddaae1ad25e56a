"""Open the gripper."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class OpenGripper(ArmBehaviour):
    """Open the fingers; what they held is no payload any more."""

    patience = Input(float, default=2.0, doc="Longest simulated time to try [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Start to open."""
        self.gripper.open()

    def update(self) -> Status:
        """Wait until the fingers are open."""
        self.feedback_message = f"{1000 * self.gripper.width:.0f} mm open"
        if self.gripper.is_open:
            self.arm.payload = None
            return Status.SUCCESS
        if self.elapsed > self.patience:
            return self.fail(
                f"the fingers are {1000 * self.gripper.width:.1f} mm apart after "
                f"{self.patience:g} s; something holds them"
            )
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Keep the fingers where they are when halted."""
        if new_status == Status.INVALID:
            self.gripper.stop()
