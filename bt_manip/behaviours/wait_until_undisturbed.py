"""Wait until the arm is at rest and undisturbed."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class WaitUntilUndisturbed(ArmBehaviour):
    """Wait until the arm is at rest and no external force acts on it; succeed at once if so."""

    patience = Input(float, default=5.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}

    def update(self) -> Status:
        """Check motion and external force."""
        if self.steady(self.arm.undisturbed):
            return Status.SUCCESS
        state = "an external force acts on the arm" if self.arm.at_rest else "the arm moves"
        if self.elapsed > self.patience:
            cause = self.arm.describe_error() if self.arm.at_rest else state
            return self.fail(f"{cause}, still after {self.patience:g} s")
        self.feedback_message = state
        return Status.RUNNING
