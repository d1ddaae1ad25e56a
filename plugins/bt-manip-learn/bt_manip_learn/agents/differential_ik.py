"""Differential inverse kinematics for small displacements of the tool."""

from typing import Any

import numpy as np
import pinocchio as pin

IK_ERROR = 1e-5
"""Error of the tool pose at which the iteration ends [m] and [rad]."""

IK_STEPS = 4
"""Largest number of iterations."""

HOMING = 0.01
"""Share of the distance to home that redundant joints move per iteration, so that they do not
drift into limits."""


def differential_ik(model: Any, q: np.ndarray, T_wt: pin.SE3) -> np.ndarray:
    """Return a configuration near `q` that brings the tool as close as possible to a pose.

    Damped least squares (Nakamura & Hanafusa, 1986), inside the position limits; redundant joints
    move towards home.

    Args:
        model: The arm's `RobotModel`.
        q: Initial configuration [rad].  # (nq,)
        T_wt: Pose of the tool in the world.
    """  # (nq,)
    q = q.copy()
    weights = (model.limits.velocity / model.limits.velocity.max()) ** 2
    for _ in range(IK_STEPS):
        T = model.pose(q)
        turn = pin.log3(T_wt.rotation @ T.rotation.T)
        error = np.concatenate([T_wt.translation - T.translation, turn])
        if np.abs(error).max() < IK_ERROR:
            break
        J = model.jacobian(q)
        WJ = weights[:, np.newaxis] * J.T
        homing = HOMING * (model.home - q)
        q += homing + WJ @ np.linalg.solve(J @ WJ + 1e-5 * np.eye(6), error - J @ homing)
        q = np.clip(q, model.limits.lower, model.limits.upper)
    return q
