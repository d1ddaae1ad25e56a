"""Behaviours that set the speed of an arm, stop it, and wait until it is ready again."""

from math import inf

from bt_manip.bt import Input, Status, Traits

from .arm_behaviour import ArmBehaviour


class SetSpeed(ArmBehaviour):
    """Set the speed scaling of the arm: the fraction of the planned speed at which it moves.

    A running motion stays on its path. At 0 it pauses, and continues when the scaling is raised.
    With a lower `tool_speed` it is slowed down as soon as the limits of the joints allow.
    """

    traits = Traits()
    needs_rest = False

    speed = Input(
        float, default=1.0, doc="Fraction of the planned speed.", at_least=0.0, at_most=1.0
    )

    tool_speed = Input(
        float,
        default=0.0,
        doc="Maximum speed of the tool [m/s], up to that of the robot, which 0 sets.",
        at_least=0.0,
    )

    def start(self) -> None:
        """Set the arm's speed scaling and the limit of the tool's speed."""
        self.arm.speed_scale = self.speed
        self.arm.tool_speed = self.tool_speed or inf

    def update(self) -> Status:
        """Succeed; the arm changes its speed in the following steps."""
        return Status.SUCCESS


class Stop(ArmBehaviour):
    """Stop the arm on its path and cancel its motion."""

    traits = Traits()
    needs_rest = False

    compliant = Input(
        bool, default=False, doc="Whether the arm is compliant until its next motion."
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


class Recover(ArmBehaviour):
    """Clear errors and reflexes of a real arm; succeed immediately without any."""

    traits = Traits()
    patience = Input(float, default=5.0, doc="Timeout in simulated time [s].", at_least=0.0)

    def start(self) -> None:
        """Start the recovery."""
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


class WaitUntilUndisturbed(ArmBehaviour):
    """Wait until the arm is at rest and no external force acts on it.

    A real arm that has stopped with an error, such as a reflex, is recovered once; if a person has
    to help, as after a user stop, it waits.
    """

    traits = Traits()
    patience = Input(float, default=5.0, doc="Timeout in simulated time [s].", at_least=0.0)

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
