"""Set the pace of the arm."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class SetSpeed(ArmBehaviour):
    """Set at which fraction of its planned speed the arm moves, from now on and at once.

    A motion that goes on meanwhile stays on its path. At 0 it pauses, and goes on when the speed is
    raised again.
    """

    speed = Input(float, default=1.0, doc="Fraction of the planned speed, 0 to 1.")

    def start(self) -> None:
        """Set the arm's pace."""
        self.arm.speed_scale = self.speed

    def update(self) -> Status:
        """Succeed: the arm changes its pace by itself."""
        return Status.SUCCESS
