"""Stop the arm."""

from bt_manip.bt import Status

from .arm_behaviour import ArmBehaviour


class Stop(ArmBehaviour):
    """Bring the arm to rest on its path, and give up the motion that it was in."""

    def start(self) -> None:
        """Begin to brake."""
        self.arm.stop()

    def update(self) -> Status:
        """Wait until the arm rests."""
        if self.arm.moving:
            self.feedback_message = f"{self.arm.remaining:.2f} s to rest"
            return Status.RUNNING
        return Status.SUCCESS
