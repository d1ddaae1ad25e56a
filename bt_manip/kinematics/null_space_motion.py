"""Joint motion in the null space of the tool's Jacobian."""

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

_DAMPING = 1e-4  # regularization of J J^T near singularities
_MIN_PIVOT = 1e-15


def null_space_step(arm: RobotModel, q: np.ndarray, dq: np.ndarray, gain: float) -> np.ndarray:
    """Add null-space motion away from the joint limits to a step; the tool's motion is kept.

    Args:
        arm: The arm; its data are written to. Without redundancy, the given step is returned.
        q: The configuration.  # (nq,)
        dq: The given step.  # (nq,)
        gain: Step of a joint away from its limit, at the limit [rad].
    """  # (nq,)
    if arm.nq <= 6:
        return dq
    lower, upper = arm.limits.sampling_bounds()
    normalized = (q - 0.5 * (lower + upper)) * (2.0 / (upper - lower))  # -1 to 1
    desired = -gain * (normalized * normalized * normalized) - dq
    jacobian = pin.computeFrameJacobian(arm.model, arm.data, q, arm.tool_frame_id, pin.LOCAL)
    square = jacobian.dot(jacobian.T)
    square.ravel()[:: len(square) + 1] += _DAMPING
    solution = np.empty(len(square))
    mujoco.mju_cholFactor(square, _MIN_PIVOT)
    mujoco.mju_cholSolve(solution, square, jacobian.dot(desired))
    return dq + desired - solution.dot(jacobian)
