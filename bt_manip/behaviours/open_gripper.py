"""Open the gripper."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class OpenGripper(ArmBehaviour):
    """Open the gripper; the arm then has no payload."""

    needs_gripper = True

    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Start to open."""
        self.gripper.open()

    def update(self) -> Status:
        """Wait until the gripper is open."""
        self.feedback_message = self.gripper.status
        if self.gripper.is_open:
            self.arm.payload = None
            return Status.SUCCESS
        if self.elapsed > self.patience:
            return self.fail(
                f"the gripper is not open after {self.patience:g} s ({self.gripper.status}); "
                "something obstructs it"
            )
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop opening when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()
