"""Move the tool to a pose."""

from bt_manip.bt import Input

from .move import PlannedMove
from .poses import pose_input


class MoveToPose(PlannedMove):
    """Move the tool to a pose in the world, around obstacles."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")
    linear = Input(bool, default=False, doc="Whether the tool moves along a straight line.")

    def start(self) -> None:
        """Plan a collision-free motion, or a straight line of the tool."""
        if self.linear:
            self.arm.move_linear(self.pose, speed=self.speed)
        else:
            self.arm.move_to_pose(self.pose, speed=self.speed, **self.planning())
