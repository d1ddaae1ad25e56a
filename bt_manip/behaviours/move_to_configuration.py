"""Move the arm to a configuration."""

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour


class MoveToConfiguration(MotionBehaviour):
    """Move the arm's joints to given positions."""

    configuration = Input(list[float], doc="Joint positions, separated by ';' [rad].")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move all joints on a straight line of the joint space."""
        self.arm.move_to_configuration(self.configuration, speed=self.speed)
