"""Kinds of grippers: each a `bt_manip.robots.Gripper` in a package of its own."""

from .two_finger import Hand as Hand
from .two_finger import TwoFingerGripper as TwoFingerGripper
from .two_finger import two_finger_gripper as two_finger_gripper
