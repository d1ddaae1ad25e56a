"""Move the tool to a pose."""

from bt_manip.bt import Input

from .move import PlannedMove, PoseMove


class MoveToPose(PoseMove, PlannedMove):
    """Move the tool to a pose in the world, around obstacles."""

    linear = Input(bool, default=False, doc="Whether the tool moves along a straight line.")

    def start(self) -> None:
        """Plan a collision-free motion, or a straight line of the tool."""
        if self.linear:
            self.arm.move_linear(self.target, speed=self.speed)
        else:
            self.arm.move_to_pose(self.target, speed=self.speed, **self.planning())
