"""Reach down to an object."""

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour
from .poses import GRIP_HEIGHT, centre_pose, grips_from_above, nearest_turn


class Reach(MotionBehaviour):
    """Bring the open fingers around an object on a straight line."""

    object = Input(str, doc="Name of the object.")
    height = Input(
        float, default=GRIP_HEIGHT, doc="Height of the tool over the object's centre [m]."
    )
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move straight to the grip that needs the least turn of the tool."""
        grips = grips_from_above(centre_pose(self.cell, self.object), self.height)
        self.arm.move_linear(nearest_turn(grips, self.T_wt), speed=self.speed)
