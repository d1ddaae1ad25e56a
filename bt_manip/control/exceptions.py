"""What can go wrong in control."""

from bt_manip.exceptions import BtManipError


class ControlError(BtManipError):
    """A command or a gain that a controller cannot follow."""


class ControllerFault(Exception):
    """A controller gave what no arm can be driven with; the arm is braked without it.

    Not a `BtManipError`: it is a fault of the controller, not of whoever uses it.

    Attributes:
        kind: Kind of the controller.
        culprit: Name of the module that the controller's class is in.
    """

    def __init__(self, kind: str, culprit: str, problem: str, time: float) -> None:
        """Say which controller did what, and when [s]."""
        super().__init__(f"controller '{kind}' {problem}, at {time:.3f} s; the arm was stopped")
        self.kind = kind
        self.culprit = culprit
