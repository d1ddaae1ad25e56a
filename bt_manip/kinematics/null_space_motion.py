"""Joint motion in the null space of the tool's Jacobian."""

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

_DAMPING = 1e-4  # added to J J^T, so that it can be factored near singularities
_MIN_PIVOT = 1e-15


def null_space_step(arm: RobotModel, q: np.ndarray, dq: np.ndarray, gain: float) -> np.ndarray:
    """Return a step that moves the tool as another does, and joints away from their limits.

    Args:
        arm: The arm; its data are written to. Without redundancy, the other step is returned.
        q: The configuration.  # (nq,)
        dq: The other step.  # (nq,)
        gain: Step away from a limit of a joint that is at it [rad].
    """  # (nq,)
    if arm.nq <= 6:
        return dq
    lower, upper = arm.limits.sampling_bounds()
    normalized = (q - 0.5 * (lower + upper)) * (2.0 / (upper - lower))  # between them, -1 to 1
    desired = -gain * (normalized * normalized * normalized) - dq
    jacobian = pin.computeFrameJacobian(arm.model, arm.data, q, arm.tool_frame_id, pin.LOCAL)
    square = jacobian.dot(jacobian.T)
    square.ravel()[:: len(square) + 1] += _DAMPING
    solution = np.empty(len(square))
    mujoco.mju_cholFactor(square, _MIN_PIVOT)
    mujoco.mju_cholSolve(solution, square, jacobian.dot(desired))
    return dq + desired - solution.dot(jacobian)
