"""Suction cups, modelled by MuJoCo's adhesion actuator."""

from .gripper import SuctionGripper as SuctionGripper
from .parameters import suction_gripper as suction_gripper
