"""PD control with gravity compensation."""

from collections.abc import Sequence

import numpy as np

from bt_manip.robots import Robot

from .controller import Controller
from .pd_law import POSITION_GAIN, VELOCITY_GAIN, pd_torque, per_joint


class GravityCompensatedPD(Controller):
    """PD control of each joint with gravity compensation.

    ``tau = Kp e + Kd de/dt + g(q)``: no inertia, no friction, no integral. It lags behind a fast
    reference and has a steady-state error from friction. Most arms come with such a controller; it
    is the baseline for computed torque.
    """

    kind = "gravity_compensated_pd"
    saturates = True

    def _build(
        self,
        robot: Robot,
        kp: float | Sequence[float] | None = None,
        kd: float | Sequence[float] | None = None,
    ) -> None:
        """Set the gains.

        Args:
            robot: The robot to control.
            kp: Position gains [N m/rad]; default: `POSITION_GAIN` times the effort limit.
            kd: Velocity gains [N m s/rad]; default: `VELOCITY_GAIN` times the effort limit.

        Raises:
            ControlError: If a gain is negative, or their number is not that of the joints.
        """
        super()._build(robot)
        effort = robot.limits.effort
        self.kp = per_joint("kp", POSITION_GAIN * effort if kp is None else kp, effort.size)
        self.kd = per_joint("kd", VELOCITY_GAIN * effort if kd is None else kd, effort.size)

    def compute(
        self, q: np.ndarray, v: np.ndarray, q_ref: np.ndarray, v_ref: np.ndarray, a_ref: np.ndarray
    ) -> np.ndarray:
        """Return the PD torques plus gravity [N m]."""  # (nv,)
        return pd_torque(self.model, self.kp, self.kd, q, v, q_ref, v_ref)
