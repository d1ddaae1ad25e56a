"""Motion of the joints that leaves the tool where it is."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .least_squares import damped_step

_EVASION = 3  # odd power of the place between the limits, -1 to 1


class SelfMotion:
    """Use the freedom of an arm that has more than six joints; others have none."""

    def __init__(self, model: RobotModel) -> None:
        """Prepare for an arm; its data are written to."""
        self._model, self._data, self._frame = model.model, model.data, model.tool_frame_id
        self._free = model.nq > 6
        lower = np.maximum(model.limits.lower, -np.pi)
        upper = np.minimum(model.limits.upper, np.pi)
        self._middle, self._half = 0.5 * (lower + upper), 0.5 * (upper - lower)

    def away_from_limits(self, q: np.ndarray) -> np.ndarray:
        """Give a self-motion away from the joint limits, to go along a path with [rad/m]."""
        if not self._free:
            return np.zeros(len(q))
        wish = -(((q - self._middle) / self._half) ** _EVASION)
        jacobian = pin.computeFrameJacobian(self._model, self._data, q, self._frame, pin.LOCAL)
        return wish - damped_step(jacobian, jacobian.dot(wish), 1e-4)  # (nq,)
