"""Errors about robots."""

from bt_manip.exceptions import BtManipError


class RobotError(BtManipError):
    """A robot's description and its model do not fit each other, or one of them is wrong."""


class GripperError(BtManipError):
    """A command that a gripper cannot follow, or one to a robot that has none."""
