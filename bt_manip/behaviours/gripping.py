"""What behaviours that come to an object to grip it have in common."""

from bt_manip.grasping import GraspChoice

from .arm_behaviour import MotionBehaviour


class GrippingBehaviour(MotionBehaviour):
    """Move for a grasp of an object."""

    _choice: GraspChoice | None = None

    @property
    def choice(self) -> GraspChoice:
        """What chooses grasps for the robot that is meant."""
        if self._choice is None or self._choice.arm is not self.arm:
            self._choice = GraspChoice(self.cell, self.arm)
        return self._choice
