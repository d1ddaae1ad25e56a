"""Move along the tool's approach axis."""

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input

from .move import Move


class Approach(Move):
    """Move the tool forwards along its z axis."""

    distance = Input(float, default=0.1, doc="Distance [m].")

    def start(self) -> None:
        """Move along the z axis of the tool."""
        self.advance_by(self.distance)

    def advance_by(self, distance: float) -> None:
        """Move the tool along its z axis by a distance [m].

        Raises:
            MotionError: When the line cannot be followed or is blocked.
        """
        T_wt = self.arm.model.pose(self.arm.target)
        offset = pin.SE3(np.eye(3), np.array([0.0, 0.0, distance]))
        self.arm.move_linear(T_wt * offset, speed=self.speed)


class Retreat(Approach):
    """Move the tool backwards along its z axis."""

    def start(self) -> None:
        """Move against the z axis of the tool."""
        self.advance_by(-self.distance)
