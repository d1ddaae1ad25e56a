"""Kinds of grippers for bt-manip: multi-finger hands that close along a synergy, suction cups."""

from .hand import Hand as Hand
from .suction import SuctionGripper as SuctionGripper
from .suction import suction_gripper as suction_gripper
