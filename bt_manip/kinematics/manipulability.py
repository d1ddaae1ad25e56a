"""Manipulability of a tool, and its gradient."""

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import shown
from bt_manip.robots import RobotModel, invalid
from bt_manip.spatial import as_numbers

_MIN_VOLUME = 1e-9  # lower bound at singularities, for the logarithm and squared singular values


def manipulability(jacobian: np.ndarray) -> float:
    """Return ``sqrt(det(J J^T))``, the product of the singular values.

    Yoshikawa, Manipulability of Robotic Mechanisms, IJRR 1985. It is zero if the tool cannot move
    in some direction; metres and radians are not weighted. With fewer joints than rows it is
    ``sqrt(det(J^T J))``, zero if the columns are linearly dependent.

    Args:
        jacobian: Jacobian of a frame, or some of its rows.  # (m, n)

    Raises:
        MotionError: If it is not a matrix of finite numbers.
    """
    matrix = as_numbers(jacobian)
    if matrix.ndim != 2 or not matrix.size or not np.isfinite(matrix).all():
        raise invalid(f"a Jacobian must be a matrix of finite numbers, got {shown(jacobian)}")
    return _volume(matrix)


def _volume(jacobian: np.ndarray) -> float:
    return float(np.linalg.svd(jacobian, compute_uv=False).prod())


def manipulability_gradient(jacobian: np.ndarray) -> np.ndarray:
    """Return the gradient of the logarithm of the manipulability.

    Its component j is ``tr(J^+ dJ/dq_j)``. With the columns ``(v_i, w_i)`` of J, ``dJ_i/dq_j`` is
    ``(w_j x v_i, w_j x w_i)`` for j < i and ``(w_i x v_j, 0)`` for j >= i.

    Args:
        jacobian: Jacobian of the last frame of a chain in the world's axes; columns of fixed joints
            are zero or left out.  # (6, n)
    """
    linear, angular = jacobian[:3].T, jacobian[3:].T  # (n, 3)
    turned_linear = np.cross(angular[:, np.newaxis], linear)  # [j, i]: w_j x v_i
    turned_angular = np.cross(angular[:, np.newaxis], angular)
    before = np.tri(len(linear), k=-1, dtype=bool).T[:, :, np.newaxis]  # j < i
    change = np.concatenate(
        [
            np.where(before, turned_linear, turned_linear.transpose(1, 0, 2)),
            np.where(before, turned_angular, 0.0),
        ],
        axis=2,
    )  # (n, n, 6)
    return np.einsum("ik,jik->j", np.linalg.pinv(jacobian, rcond=_MIN_VOLUME**0.5), change)


def log_manipulability(arm: RobotModel, moving: np.ndarray | None) -> tuple[float, np.ndarray]:
    """Return the logarithm of the tool's manipulability, and its gradient.

    Args:
        arm: The arm, after `pin.computeJointJacobians`.
        moving: Which joints may move; None for all.  # (nv,)
    """
    moving = np.ones(arm.model.nv, dtype=bool) if moving is None else moving
    jacobian = pin.getFrameJacobian(
        arm.model, arm.data, arm.tool_frame_id, pin.LOCAL_WORLD_ALIGNED
    )[:, moving]
    gradient = np.zeros(len(moving))
    gradient[moving] = manipulability_gradient(jacobian)
    return float(np.log(max(_volume(jacobian), _MIN_VOLUME))), gradient
