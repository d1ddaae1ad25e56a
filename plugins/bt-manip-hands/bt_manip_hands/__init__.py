"""Hands with several fingers, closed as one, as a kind of gripper for bt-manip."""

from .hand import Hand as Hand
