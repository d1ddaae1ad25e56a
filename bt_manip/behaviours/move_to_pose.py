"""Move the tool to a pose."""

import pinocchio as pin

from bt_manip.bt import Input
from bt_manip.checks import invalid
from bt_manip.kinematics import PoseTarget, PositionTarget, Target

from .move import PlannedMove
from .poses import pose_input


class MoveToPose(PlannedMove):
    """Move the tool to a pose in the world, around obstacles."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")
    linear = Input(bool, default=False, doc="Whether the tool moves along a straight line.")
    free_axis = Input(
        str,
        default="",
        doc="Axis of the tool, x, y or z, about which it may turn; 'all' for any rotation.",
    )
    cone = Input(float, default=0.0, doc="Largest angle by which the free axis may tilt [rad].")

    def start(self) -> None:
        """Plan a collision-free motion, or a straight line of the tool."""
        if self.linear:
            if self.free_axis:
                raise invalid("a line to a pose has no free_axis")
            self.arm.move_linear(self.pose, speed=self.speed)
        else:
            self.arm.move_to_pose(self._target(), speed=self.speed, **self.planning())

    def _target(self) -> pin.SE3 | Target:
        """Return the pose, or the target with its free rotations."""
        tool = self.arm.ik.tool
        if self.free_axis == "all":
            return PositionTarget(tool, self.pose.translation)
        if self.free_axis or self.cone:
            return PoseTarget(tool, self.pose, free_axis=self.free_axis or None, cone=self.cone)
        return self.pose
