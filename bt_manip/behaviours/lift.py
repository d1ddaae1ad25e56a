"""Lift what the gripper holds."""

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input

from .arm_behaviour import MotionBehaviour


class Lift(MotionBehaviour):
    """Raise the tool straight up by a height."""

    height = Input(float, default=0.4, doc="How far up [m].")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move up the vertical through the tool."""
        T_wt = self.T_wt
        up = T_wt.translation + np.array([0.0, 0.0, self.height])
        self.arm.move_linear(pin.SE3(T_wt.rotation, up), speed=self.speed)
