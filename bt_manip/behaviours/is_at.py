"""Check the pose of the tool."""

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input, Status

from .poses import pose_input
from .robot_port import RobotCondition


class IsAt(RobotCondition):
    """Check that the tool is at a pose."""

    pose = pose_input("Pose of the tool in the world: x;y;z;qw;qx;qy;qz [m].")
    position_tolerance = Input(float, default=1e-3, doc="Largest distance [m].")
    rotation_tolerance = Input(float, default=1e-2, doc="Largest angle [rad].")

    def update(self) -> Status:
        """Compare the measured tool pose with the asked one."""
        T_wt = self.arm.model.pose(self.arm.robot.q)
        error = T_wt.actInv(self.pose)
        distance = float(np.linalg.norm(error.translation))
        angle = float(np.linalg.norm(pin.log3(error.rotation)))
        if distance <= self.position_tolerance and angle <= self.rotation_tolerance:
            return Status.SUCCESS
        return self.fail(f"the tool is {1000 * distance:.1f} mm and {angle:.3f} rad away")
