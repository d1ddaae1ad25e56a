"""Move the tool to a pose."""

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour
from .poses import pose_input


class MoveToPose(MotionBehaviour):
    """Move the tool to a pose in the world."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")
    linear = Input(bool, default=False, doc="Along a straight line of the tool.")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move in joint space, or on a straight line of the tool."""
        move = self.arm.move_linear if self.linear else self.arm.move_to_pose
        move(self.pose, speed=self.speed)
