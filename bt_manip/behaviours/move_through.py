"""Move the tool through several poses."""

from bt_manip.bt import Input
from bt_manip.planning import LineTo

from .move import Move
from .poses import poses_input


class MoveThrough(Move):
    """Move the tool from pose to pose on straight lines, with rounded corners."""

    poses = poses_input(
        "Poses of the tool in the world, each x;y;z;qw;qx;qy;qz [m], with | between."
    )
    blend = Input(
        float,
        default=0.02,
        doc="How far from a corner it is rounded [m]; at 0 the tool halts there.",
    )

    def start(self) -> None:
        """Move along the lines, or say how far they could be followed."""
        steps = [LineTo(pose) for pose in self.poses]
        self.arm.move_path(steps, speed=self.speed, blend=self.blend)
