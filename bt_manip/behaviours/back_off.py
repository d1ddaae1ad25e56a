"""Back off along the path just travelled."""

from bt_manip.bt import Input

from .move import Move


class BackOff(Move):
    """Move back along the path just travelled, such as after a collision."""

    distance = Input(float, default=0.1, doc="Travel of the tool [m]; less if no more is known.")

    def start(self) -> None:
        """Move back."""
        self.arm.back_off(self.distance, self.speed)
