"""Levenberg-Marquardt from one start to one pose: the inner loop of inverse kinematics."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .least_squares import damped_step

DAMPING = 0.03  # of the squared error
STALL_STEPS = 4  # that do not bring the error below STALL_FACTOR of the least end a descent
STALL_FACTOR = 0.9


class Descended(NamedTuple):
    """Where a descent ended: configuration, position error [m], angle [rad], steps."""

    q: np.ndarray
    position_error: float
    rotation_error: float
    iterations: int
    solved: bool


class Descent:
    """Levenberg-Marquardt steps on the error ``log6`` of the tool, inside the joint limits.

    A joint at its limit that would leave it is held, and the step taken with the others.
    """

    def __init__(self, model: RobotModel, *, iterations: int) -> None:
        """Prepare for an arm.

        Args:
            model: The arm; its data are written to.
            iterations: Steps at the most.
        """
        self.iterations = iterations
        self._model, self._data, self._frame = model.model, model.data, model.tool_frame_id
        self.lower, self.upper = model.limits.lower, model.limits.upper

    def __call__(
        self,
        T_wt: pin.SE3,
        q: np.ndarray,
        *,
        position_tolerance: float,
        rotation_tolerance: float,
        lower: np.ndarray | None = None,
        upper: np.ndarray | None = None,
        patience: int = STALL_STEPS,
    ) -> Descended:
        """Descend from a configuration inside the limits to the nearest solution downhill.

        Args:
            T_wt: Pose of the tool in the world.
            q: Where to start.  # (nq,)
            position_tolerance: Of a solution [m].
            rotation_tolerance: Of a solution [rad].
            lower: Limits of the positions, by default the arm's.  # (nq,)
            upper: Limits of the positions, by default the arm's.  # (nq,)
            patience: Steps without progress that end the descent.
        """
        model, data, frame = self._model, self._data, self._frame
        lower = self.lower if lower is None else lower
        upper = self.upper if upper is None else upper
        best, stalled = np.inf, 0
        position = rotation = np.inf
        best_q, best_position, best_rotation = q, np.inf, np.inf
        for step in range(self.iterations + 1):
            pin.computeJointJacobians(model, data, q)
            T_td = pin.updateFramePlacement(model, data, frame).actInv(T_wt)
            error = pin.log6(T_td).np
            x, y, z = T_td.translation.tolist()
            position = (x * x + y * y + z * z) ** 0.5
            square = float(error.dot(error))
            angular = error[3:]
            rotation = float(angular.dot(angular)) ** 0.5
            if position <= position_tolerance and rotation <= rotation_tolerance:
                return Descended(q, position, rotation, step, True)
            norm = square**0.5
            if norm < best:
                best_q, best_position, best_rotation = q, position, rotation
            if norm < STALL_FACTOR * best:
                stalled = 0
            else:
                stalled += 1
                if stalled >= patience:
                    break
            best = min(best, norm)
            jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
            jacobian = pin.Jlog6(T_td.inverse()).dot(jacobian)  # d error = -jacobian dq
            dq = damped_step(jacobian, error, DAMPING * square)
            moved = q + dq
            if (moved < lower).any() or (moved > upper).any():
                held = ((q <= lower) & (dq < 0.0)) | ((q >= upper) & (dq > 0.0))
                if held.any():
                    dq = damped_step(jacobian * ~held, error, DAMPING * square + 1e-12)
                    moved = q + dq
                moved = np.minimum(np.maximum(moved, lower), upper)
            q = moved
        return Descended(best_q, best_position, best_rotation, step, False)
