"""Move the arm to a configuration."""

from bt_manip.bt import Input

from .move import PlannedMove


class MoveToConfiguration(PlannedMove):
    """Move the arm's joints to given positions, around obstacles."""

    configuration = Input(list[float], doc="Joint positions, separated by ';' [rad].")

    def start(self) -> None:
        """Plan a collision-free motion; a joint-space segment where that is free."""
        self.arm.move_to_configuration(self.configuration, speed=self.speed, **self.planning())
