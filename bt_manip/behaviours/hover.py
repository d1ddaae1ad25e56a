"""Hover over an object."""

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour
from .poses import GRIP_HEIGHT, centre_pose, grips_from_above


class Hover(MotionBehaviour):
    """Move the tool over an object, turned so that the fingers can straddle it.

    Of the configurations over the object it takes the nearest from which the arm can go straight
    down to it.
    """

    object = Input(str, doc="Name of the object.")
    height = Input(float, default=0.4, doc="Height of the tool over the object's centre [m].")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move to the nearest of the configurations over the object."""
        poses = grips_from_above(centre_pose(self.cell, self.object), self.height)
        descent = max(self.height - GRIP_HEIGHT, 0.0)
        self.arm.move_to_pose(poses, speed=self.speed, approach=descent)
