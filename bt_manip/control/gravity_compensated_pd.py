"""A plain PD controller that carries the arm's weight."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.control.controller import Controller
from bt_manip.control.gains import per_joint
from bt_manip.robots import Robot


class GravityCompensatedPD(Controller):
    """Pull each joint by a damped spring, and carry the arm's weight.

    ``tau = Kp e + Kd de/dt + g(q)``: no inertia, no friction, no integral. It lags behind a fast
    reference and stands off by its friction at rest; it is what most arms come with, and shows
    what computed torque is good for.
    """

    kind = "gravity_compensated_pd"
    cuts_to_limits = True

    def _build(
        self,
        robot: Robot,
        kp: float | Sequence[float] | None = None,
        kd: float | Sequence[float] | None = None,
    ) -> None:
        """Set the gains.

        Args:
            robot: The robot to control.
            kp: Of the position error [N m/rad]; default: 15 times the effort limit.
            kd: Of the velocity error [N m s/rad]; default: 0.6 times the effort limit.

        Raises:
            ControlError: When a gain is negative, or their number is not that of the joints.
        """
        super()._build(robot)
        n = len(robot.description.arm_joints)
        effort = robot.limits.effort
        self.kp = per_joint("kp", 15.0 * effort if kp is None else kp, n)
        self.kd = per_joint("kd", 0.6 * effort if kd is None else kd, n)

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Give the efforts of the springs, the dampers and the weight [N m]."""  # (nv,)
        model = self.model
        gravity = pin.computeGeneralizedGravity(model.model, model.data, q)
        return self.kp * (q_ref - q) + self.kd * (v_ref - v) + gravity
