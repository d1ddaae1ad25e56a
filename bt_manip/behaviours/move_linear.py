"""Move the tool along a straight line."""

from .move import Move
from .poses import pose_input


class MoveLinear(Move):
    """Move the tool to a pose along a straight line, with uniform rotation."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")

    def start(self) -> None:
        """Move along the line, or fail with the fraction that can be followed."""
        self.arm.move_linear(self.pose, speed=self.speed)
