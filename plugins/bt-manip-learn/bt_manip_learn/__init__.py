"""Learning from and for the trees of bt-manip: agents, environments, demonstrations."""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_learn.native import NativePD as NativePD
    from bt_manip_learn.native import NativeTwoFingerGripper as NativeTwoFingerGripper
    from bt_manip_learn.ray_pool import RayPool as RayPool

__getattr__ = lazy_exports(__name__)
