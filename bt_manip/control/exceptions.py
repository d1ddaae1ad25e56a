"""Errors of controllers."""

from bt_manip.exceptions import BtManipError


class ControlError(BtManipError):
    """A command or a gain is invalid."""


class ControllerFault(Exception):
    """A controller raised or returned invalid torques; a PD controller has taken over.

    Not a `BtManipError`: the controller is at fault, not its user.

    Args:
        kind: Kind of the controller.
        problem: The problem, as a predicate.
        time: Simulated time [s].

    Attributes:
        culprit: Module of the controller's class.
    """

    def __init__(self, kind: str, culprit: str, problem: str, time: float) -> None:
        super().__init__(f"controller '{kind}' {problem}, at {time:.3f} s; the arm was stopped")
        self.culprit = culprit
