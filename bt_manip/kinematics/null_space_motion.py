"""Joint motion in the null space of the tool's Jacobian."""

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

_DAMPING = 1e-4  # added to J J^T, so that it can be factored near singularities
_MIN_PIVOT = 1e-15


class NullSpaceMotion:
    """Motion of a redundant arm's joints that does not move the tool."""

    def __init__(self, model: RobotModel) -> None:
        """Prepare for an arm; its data are written to."""
        self._model, self._data, self._frame = model.model, model.data, model.tool_frame_id
        self._redundant = model.nq > 6
        lower, upper = model.limits.sampling_bounds()
        self._middle, self._inverse_half = 0.5 * (lower + upper), 2.0 / (upper - lower)

    def step(self, q: np.ndarray, dq: np.ndarray, gain: float) -> np.ndarray:
        """Return a step that moves the tool as another does, and joints away from their limits.

        Args:
            q: The configuration.  # (nq,)
            dq: The other step.  # (nq,)
            gain: Step away from a limit of a joint that is at it [rad].
        """
        if not self._redundant:
            return dq
        normalized = (q - self._middle) * self._inverse_half  # between the limits, -1 to 1
        desired = -gain * (normalized * normalized * normalized) - dq
        jacobian = pin.computeFrameJacobian(self._model, self._data, q, self._frame, pin.LOCAL)
        square = jacobian.dot(jacobian.T)
        square.ravel()[:: len(square) + 1] += _DAMPING
        solution = np.empty(len(square))
        mujoco.mju_cholFactor(square, _MIN_PIVOT)
        mujoco.mju_cholSolve(solution, square, jacobian.dot(desired))
        return dq + desired - solution.dot(jacobian)  # (nq,)
