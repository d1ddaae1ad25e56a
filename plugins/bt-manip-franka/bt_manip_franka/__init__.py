"""Franka's arms and hand as devices, by libfranka."""

from bt_manip_franka.device import FrankaArm as FrankaArm
from bt_manip_franka.gripper import FrankaHand as FrankaHand
