"""Motion of the joints that leaves the tool where it is."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .least_squares import damped_step


class SelfMotion:
    """Use the freedom of an arm that has more than six joints; others have none."""

    def __init__(self, model: RobotModel) -> None:
        """Prepare for an arm; its data are written to."""
        self._model, self._data, self._frame = model.model, model.data, model.tool_frame_id
        self._free = model.nq > 6
        lower = np.maximum(model.limits.lower, -np.pi)
        upper = np.minimum(model.limits.upper, np.pi)
        self._middle, self._inverse_half = 0.5 * (lower + upper), 2.0 / (upper - lower)

    def onwards(self, q: np.ndarray, dq: np.ndarray, way: float) -> np.ndarray:
        """Give the step that moves the tool as another does, and the joints away from their limits.

        Args:
            q: Where the arm is.  # (nq,)
            dq: The other step.  # (nq,)
            way: How far along a path that is [m].
        """
        if not self._free:
            return dq
        place = (q - self._middle) * self._inverse_half  # between the limits, -1 to 1
        wish = -way * (place * place * place) - dq
        jacobian = pin.computeFrameJacobian(self._model, self._data, q, self._frame, pin.LOCAL)
        return dq + wish - damped_step(jacobian, jacobian.dot(wish), 1e-4)  # (nq,)
