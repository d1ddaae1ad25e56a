"""Set the speed scaling of the arm."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour


class SetSpeed(ArmBehaviour):
    """Set the speed scaling of the arm: the fraction of the planned speed at which it moves.

    A running motion stays on its path. At 0 it pauses, and continues when the scaling is raised.
    """

    needs_rest = False

    speed = Input(float, default=1.0, doc="Fraction of the planned speed, 0 to 1.")

    def start(self) -> None:
        """Set the arm's speed scaling."""
        self.arm.speed_scale = self.speed

    def update(self) -> Status:
        """Succeed: the arm changes its speed in the following steps."""
        return Status.SUCCESS
