"""Reach down to an object."""

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour
from .poses import GRIP_HEIGHT, centre_pose, grips_from_above, nearest_turn
from .room import HandRoom, with_room

_TOO_DEEP = -3e-3  # [m]; shapes of hands are a little thicker than hands


class Reach(MotionBehaviour):
    """Bring the open fingers around an object on a straight line, clear of its neighbours."""

    object = Input(str, doc="Name of the object.")
    height = Input(
        float, default=GRIP_HEIGHT, doc="Height of the tool over the object's centre [m]."
    )
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move straight to the grip with room that needs the least turn of the tool."""
        grips = grips_from_above(centre_pose(self.cell, self.object), self.height)
        free, most = with_room(grips, HandRoom(self.cell, self.arm.robot, [self.object]))
        if most.distance < _TOO_DEEP:
            self.fail(f"'{most.nearest}' leaves the fingers no room at '{self.object}'")
            return
        self.arm.move_linear(nearest_turn(free, self.T_wt), speed=self.speed)
