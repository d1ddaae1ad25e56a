"""A WidowX AI as a device, by its maker's driver."""

from bt_manip_trossen.arm import WidowXAI as WidowXAI
from bt_manip_trossen.gripper import Carriages as Carriages
