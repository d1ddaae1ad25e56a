"""Move the tool along a straight line."""

from .move import PoseMove


class MoveLinear(PoseMove):
    """Move the tool to a pose along a straight line, with uniform rotation."""

    def start(self) -> None:
        """Move along the line, or fail with the fraction that can be followed."""
        self.arm.move_linear(self.target, speed=self.speed)
