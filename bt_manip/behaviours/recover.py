"""Clear errors of a real arm."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class Recover(ArmBehaviour):
    """Clear errors and reflexes of a real arm; succeed at once without any, as in simulation."""

    patience = Input(float, default=5.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Begin to recover."""
        self.arm.recover()

    def update(self) -> Status:
        """Wait until the arm is ready and at rest."""
        problem = self.arm.problem
        if not problem and self.arm.at_rest:
            return Status.SUCCESS
        self.feedback_message = problem or "the arm moves"
        if self.elapsed > self.patience:
            return self.fail(f"{self.feedback_message}, still after {self.patience:g} s")
        return Status.RUNNING
