"""Stop the arm."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class Stop(ArmBehaviour):
    """Stop the arm on its path and cancel its motion."""

    needs_rest = False

    compliant = Input(
        bool, default=False, doc="Whether the arm yields to contact until its next motion."
    )

    def start(self) -> None:
        """Start the stop."""
        self.arm.stop(compliant=self.compliant)

    def update(self) -> Status:
        """Wait until the arm is at rest."""
        if self.arm.moving:
            self.feedback_message = f"{self.arm.remaining:.2f} s until rest"
            return Status.RUNNING
        return Status.SUCCESS
