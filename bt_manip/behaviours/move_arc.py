"""Move the tool on an arc."""

from bt_manip.bt import Input
from bt_manip.planning import ArcTo

from .move import Move
from .poses import pose_input


class MoveArc(Move):
    """Move the tool to a pose on the arc of a circle, turning evenly on the way."""

    via = Input(list[float], doc="A point in the world that the arc goes through: x;y;z [m].")
    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")

    def start(self) -> None:
        """Move along the arc, or say how far it could be followed."""
        self.arm.move_path([ArcTo(self.via, self.pose)], speed=self.speed)
