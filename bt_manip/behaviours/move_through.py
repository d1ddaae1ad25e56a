"""Move the tool through several poses."""

from bt_manip.bt import Input
from bt_manip.planning import LineTo

from .move import Move
from .poses import poses_input


class MoveThrough(Move):
    """Move the tool through poses on straight lines, with blended corners."""

    poses = poses_input(
        "Poses of the tool in the world, each x;y;z;qw;qx;qy;qz [m], separated by |."
    )
    blend = Input(
        float,
        default=0.02,
        doc="Blend distance from each corner [m]; at 0 the tool stops there.",
    )

    def start(self) -> None:
        """Move along the lines, or fail with the fraction that can be followed."""
        steps = [LineTo(pose) for pose in self.poses]
        self.arm.move_path(steps, speed=self.speed, blend=self.blend)
