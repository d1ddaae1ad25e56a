"""Move the arm home."""

from .move import PlannedMove


class MoveHome(PlannedMove):
    """Move the arm to the home configuration of its description, around what is in the way."""

    def start(self) -> None:
        """Move all joints on a straight line of the joint space where that is free."""
        home = self.arm.robot.description.home
        self.arm.move_to_configuration(home, speed=self.speed, **self.planning())
