"""Move the tool along an arc."""

from bt_manip.bt import Input
from bt_manip.planning import ArcTo

from .move import Move
from .poses import pose_input


class MoveArc(Move):
    """Move the tool to a pose along a circular arc, with uniform rotation."""

    via = Input(list[float], doc="A point of the arc in the world: x;y;z [m].")
    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")

    def start(self) -> None:
        """Move along the arc, or fail with the fraction that can be followed."""
        self.arm.move_path([ArcTo(self.via, self.pose)], speed=self.speed)
