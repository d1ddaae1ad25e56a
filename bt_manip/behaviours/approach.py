"""Move along the axis of the tool."""

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input

from .move import Move


class Approach(Move):
    """Move the tool forwards along its own axis, on a straight line."""

    distance = Input(float, default=0.1, doc="How far [m].")

    def start(self) -> None:
        """Move along the z axis of the tool."""
        self.advance_by(self.distance)

    def advance_by(self, distance: float) -> None:
        """Move the tool along its z axis [m].

        Raises:
            MotionError: When the line cannot be followed or is blocked.
        """
        T_wt = self.arm.model.pose(self.arm.target)
        along = pin.SE3(np.eye(3), np.array([0.0, 0.0, distance]))
        self.arm.move_linear(T_wt * along, speed=self.speed)


class Retreat(Approach):
    """Move the tool backwards along its own axis, on a straight line."""

    def start(self) -> None:
        """Move against the z axis of the tool."""
        self.advance_by(-self.distance)
