"""Move the arm to a configuration."""

from bt_manip.bt import Input

from .move import PlannedMove


class MoveToConfiguration(PlannedMove):
    """Move the arm's joints to given positions, around what is in the way."""

    configuration = Input(list[float], doc="Joint positions, separated by ';' [rad].")

    def start(self) -> None:
        """Move all joints on a straight line of the joint space where that is free."""
        self.arm.move_to_configuration(self.configuration, speed=self.speed, **self.planning())
