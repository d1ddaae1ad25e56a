"""Move the tool on a straight line."""

from .move import Move
from .poses import pose_input


class MoveLinear(Move):
    """Move the tool to a pose on a straight line, turning evenly on the way."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")

    def start(self) -> None:
        """Move along the line, or say how far it could be followed."""
        self.arm.move_linear(self.pose, speed=self.speed)
