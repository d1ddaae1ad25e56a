"""Move the arm home."""

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour


class MoveHome(MotionBehaviour):
    """Move the arm to the home configuration of its description."""

    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move all joints on a straight line of the joint space."""
        self.arm.move_to_configuration(self.arm.robot.description.home, speed=self.speed)
