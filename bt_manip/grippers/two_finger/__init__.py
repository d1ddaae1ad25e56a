"""Grippers with two fingers that move symmetrically."""

from .antipodal_grasps import GRIP_DEPTH as GRIP_DEPTH
from .gripper import TwoFingerGripper as TwoFingerGripper
from .parameters import two_finger_gripper as two_finger_gripper
