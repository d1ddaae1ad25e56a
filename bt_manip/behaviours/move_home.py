"""Move the arm home."""

from .move import PlannedMove


class MoveHome(PlannedMove):
    """Move the arm to the home configuration of its description, around obstacles."""

    def start(self) -> None:
        """Plan a collision-free motion; a joint-space segment where that is free."""
        home = self.arm.robot.description.home
        self.arm.move_to_configuration(home, speed=self.speed, **self.planning())
