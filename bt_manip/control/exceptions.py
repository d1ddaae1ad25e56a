"""What can go wrong in control."""

from bt_manip.exceptions import BtManipError


class ControlError(BtManipError):
    """A command or a gain that a controller cannot follow."""
