"""Errors about motion."""

from bt_manip.exceptions import BtManipError


class MotionError(BtManipError):
    """A motion that cannot be done; nothing moves.

    Attributes:
        reason: ``"target"`` (bad input), ``"unreachable"``, ``"line"`` (cannot be followed to its
            end), ``"collision"`` (a target, a line or all ways are blocked), ``"robot"`` (they are,
            by another robot, which may go out of the way), ``"effort"``, ``"limits"`` or
            ``"grasp"`` (an object cannot be gripped).
        fraction: How much of a tool's path could be followed, 0 to 1; None where that is not known.
    """

    def __init__(self, message: str, *, reason: str, fraction: float | None = None) -> None:
        """Say what cannot be done, and why in one word."""
        super().__init__(message)
        self.reason, self.fraction = reason, fraction
