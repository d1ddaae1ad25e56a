"""Grippers of two fingers that mirror each other."""

from .gripper import TwoFingerGripper as TwoFingerGripper
from .hand import Hand as Hand
from .parameters import two_finger_gripper as two_finger_gripper
