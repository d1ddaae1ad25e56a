"""Wait until the arm is at rest and undisturbed."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class WaitUntilUndisturbed(ArmBehaviour):
    """Wait until the arm is at rest and no external force acts on it; succeed at once if so.

    A real arm that has stopped with an error, such as a reflex, is made to recover once; where a
    person must help, as after a user stop, it waits for that.
    """

    patience = Input(float, default=5.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}
    memory = (*ArmBehaviour.memory, "_recovered")

    _recovered = False  # whether it has tried to recover

    def start(self) -> None:
        """Wait."""
        self._recovered = False

    def update(self) -> Status:
        """Check motion and external force."""
        if self.steady(self.arm.undisturbed):
            fault = self.arm.fault
            self.feedback_message = f"ready again: {fault}" if fault else ""
            return Status.SUCCESS
        problem = self.arm.problem
        if self.arm.recoverable and not self._recovered:
            self._recovered = True
            self.arm.recover()
        state = "an external force acts on the arm" if self.arm.at_rest else "the arm moves"
        state = problem or state
        if self.elapsed > self.patience:
            cause = self.arm.describe_error() if not problem and self.arm.at_rest else state
            return self.fail(f"{cause}, still after {self.patience:g} s")
        self.feedback_message = state
        return Status.RUNNING
