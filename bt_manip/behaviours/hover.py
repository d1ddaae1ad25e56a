"""Hover over an object."""

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour
from .poses import GRIP_HEIGHT, centre_pose, grips_from_above
from .room import HandRoom, with_room


class Hover(MotionBehaviour):
    """Move the tool over an object, turned so that the fingers can straddle it.

    Of the pairs of faces it takes one that neighbours leave free, and of the configurations over
    the object the nearest from which the arm can go straight down to it.
    """

    object = Input(str, doc="Name of the object.")
    height = Input(float, default=0.4, doc="Height of the tool over the object's centre [m].")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move to the nearest of the configurations over the object."""
        grips = grips_from_above(centre_pose(self.cell, self.object), GRIP_HEIGHT)
        free, _ = with_room(grips, HandRoom(self.cell, self.arm.robot, [self.object]))
        up = np.array([0.0, 0.0, self.height - GRIP_HEIGHT])
        poses = [pin.SE3(T.rotation, T.translation + up) for T in free]
        descent = max(self.height - GRIP_HEIGHT, 0.0)
        self.arm.move_to_pose(poses, speed=self.speed, approach=descent)
