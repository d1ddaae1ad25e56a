"""Motion of the joints that leaves the tool where it is."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .least_squares import damped_step

PULLS = 12  # steps towards another configuration
_LEASH = 0.4  # [s] at full speed that a joint is pulled by in one step
_ARRIVED = 1e-3  # [rad]
_EVASION = 3  # odd power of the place between the limits, -1 to 1
_DAMPING = 1e-8


class SelfMotion:
    """Use the freedom of an arm that has more than six joints; others have none."""

    def __init__(self, model: RobotModel) -> None:
        """Prepare for an arm; its data are written to."""
        self._model, self._data, self._frame = model.model, model.data, model.tool_frame_id
        self._free = model.nq > 6
        self._speed = model.limits.velocity
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

    def towards(
        self,
        q0: np.ndarray,
        T_wt: pin.SE3,
        q: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> np.ndarray:
        """Go from a solution towards another configuration until it is as near as it gets.

        Near in the time that the joints would need. Each step is the wish to be there, put right
        by what keeps the tool at its pose.

        Args:
            q0: Where to.  # (nq,)
            T_wt: Pose of the tool.
            q: Solution for that pose.  # (nq,)
            lower: Limits of the positions.  # (nq,)
            upper: Limits of the positions.  # (nq,)

        Returns:
            A configuration near to a solution.  # (nq,)
        """
        if not self._free:
            return q
        for _ in range(PULLS):
            pin.computeJointJacobians(self._model, self._data, q)
            T_td = pin.updateFramePlacement(self._model, self._data, self._frame).actInv(T_wt)
            error = pin.log6(T_td).np
            jacobian = pin.getFrameJacobian(self._model, self._data, self._frame, pin.LOCAL)
            jacobian = jacobian * self._speed  # per second at full speed, which is the distance
            wish = (q0 - q) / self._speed
            wish *= min(1.0, _LEASH / float(np.abs(wish).max(initial=1e-12)))
            dq = self._speed * (wish + damped_step(jacobian, error - jacobian.dot(wish), _DAMPING))
            held = ((q <= lower) & (dq < 0.0)) | ((q >= upper) & (dq > 0.0))
            if held.any():
                wish, jacobian = wish * ~held, jacobian * ~held
                missing = error - jacobian.dot(wish)
                dq = self._speed * (wish + damped_step(jacobian, missing, _DAMPING))
            q = np.minimum(np.maximum(q + dq, lower), upper)
            if np.abs(dq).max() < _ARRIVED:
                break
        return q
