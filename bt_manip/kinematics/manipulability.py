"""How far a tool can move in every direction."""

import numpy as np
import pinocchio as pin

from bt_manip.checks import as_numbers, invalid, shown
from bt_manip.robots import RobotModel

_LEAST = 1e-9  # of the squared singular values, so that a singular arm has a gradient too


def manipulability(jacobian: np.ndarray) -> float:
    """Give ``sqrt(det(J J^T))``, the product of the singular values.

    Yoshikawa, Manipulability of Robotic Mechanisms, IJRR 1985. It is nought where the tool cannot
    move in some direction; metres and radians are taken together as they are. Of fewer joints than
    directions it is ``sqrt(det(J^T J))``: nought where two ways of moving them are the same.

    Args:
        jacobian: Of a frame, or some rows of it.  # (m, n)

    Raises:
        MotionError: When it is no matrix of finite numbers.
    """
    matrix = as_numbers(jacobian)
    if matrix.ndim != 2 or not matrix.size or not np.isfinite(matrix).all():
        raise invalid(f"a Jacobian must be a matrix of finite numbers, got {shown(jacobian)}")
    return _volume(matrix)


def _volume(jacobian: np.ndarray) -> float:
    return float(np.linalg.svd(jacobian, compute_uv=False).prod())


def manipulability_slope(jacobian: np.ndarray) -> np.ndarray:
    """Give the gradient of the manipulability's logarithm.

    Its component j is ``tr(J^+ dJ/dq_j)``. A joint turns or shifts what comes after it: with the
    columns ``(v_i, w_i)``, ``dJ_i/dq_j`` is ``(w_j x v_i, w_j x w_i)`` for j before i and
    ``(w_i x v_j, 0)`` from i on.

    Args:
        jacobian: Of the last frame of a chain, in the world's axes; joints that do not move are
            columns of nought, or left out.  # (6, n)
    """
    linear, angular = jacobian[:3].T, jacobian[3:].T  # (nv, 3)
    turned_linear = np.cross(angular[:, np.newaxis], linear)  # [j, i]: w_j x v_i
    turned_angular = np.cross(angular[:, np.newaxis], angular)
    before = np.tri(len(linear), k=-1, dtype=bool).T[:, :, np.newaxis]  # j before i
    change = np.concatenate(
        [
            np.where(before, turned_linear, turned_linear.transpose(1, 0, 2)),
            np.where(before, turned_angular, 0.0),
        ],
        axis=2,
    )  # (nv, nv, 6)
    return np.einsum("ik,jik->j", np.linalg.pinv(jacobian, rcond=_LEAST**0.5), change)


class ToolManipulability:
    """The manipulability of an arm's tool with some of its joints."""

    def __init__(self, arm: RobotModel, moving: np.ndarray | None = None) -> None:
        """Look at an arm.

        Args:
            arm: The arm; its data are written to.
            moving: Which joints may move; by default all.  # (nv,)
        """
        self._model, self._data, self._frame = arm.model, arm.data, arm.tool_frame_id
        self._moving = np.ones(arm.model.nv, dtype=bool) if moving is None else moving

    def measure(self) -> tuple[float, np.ndarray]:
        """Give the logarithm and its gradient, after `pin.computeJointJacobians`."""
        jacobian = pin.getFrameJacobian(
            self._model, self._data, self._frame, pin.LOCAL_WORLD_ALIGNED
        )
        jacobian = jacobian[:, self._moving]
        slope = np.zeros(len(self._moving))
        slope[self._moving] = manipulability_slope(jacobian)
        return float(np.log(max(_volume(jacobian), _LEAST))), slope
