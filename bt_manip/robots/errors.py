"""Errors about robots."""

from bt_manip.exceptions import BtManipError


class RobotError(BtManipError):
    """A robot's description or model is invalid, or the two do not match."""


class GripperError(BtManipError):
    """A command is invalid for a gripper, or the robot has no gripper."""
