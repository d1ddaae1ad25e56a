"""Grippers with two fingers, of which one or both move."""

from .antipodal_grasps import GRIP_DEPTH as GRIP_DEPTH
from .finger_travel import FingerTravel as FingerTravel
from .gripper import TwoFingerGripper as TwoFingerGripper
from .parameters import TwoFingerParameters as TwoFingerParameters
from .parameters import two_finger_gripper as two_finger_gripper
from .travel_check import travel_digests as travel_digests
