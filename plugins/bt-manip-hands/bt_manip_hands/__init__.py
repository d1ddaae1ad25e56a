"""Multi-finger hands that close along a synergy, as a kind of gripper for bt-manip."""

from .hand import Hand as Hand
