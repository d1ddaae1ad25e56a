"""PD control with gravity compensation, and its default gains."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

POSITION_GAIN = 15.0
"""Default position gain over effort limit: an error of 67 mrad saturates the motor [1/rad]."""

VELOCITY_GAIN = 0.6
"""Default velocity gain over effort limit: the motor saturates at 1.7 rad/s [s/rad]."""


def pd_torque(
    model: RobotModel,
    kp: np.ndarray,
    kd: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    q_ref: np.ndarray,
    v_ref: np.ndarray,
) -> np.ndarray:
    """Return ``kp (q_ref - q) + kd (v_ref - v) + g(q)`` [N m].

    Args:
        model: The arm with its payload.
        kp: Position gains [N m/rad].  # (nv,)
        kd: Velocity gains [N m s/rad].  # (nv,)
        q: Measured positions [rad].  # (nv,)
        v: Measured velocities [rad/s].  # (nv,)
        q_ref: Reference positions [rad].  # (nv,)
        v_ref: Reference velocities [rad/s].  # (nv,)
    """  # (nv,)
    gravity = pin.computeGeneralizedGravity(model.model, model.data, q)
    return kp * (q_ref - q) + kd * (v_ref - v) + gravity
