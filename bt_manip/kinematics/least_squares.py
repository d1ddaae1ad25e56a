"""Damped least-squares steps, with few calls."""

from functools import cache

import mujoco
import numpy as np

_ROUND = 1e-12  # above the rounding of a squared Jacobian
_FINE = 1e-10  # a damping from which on the error is scaled up
_PIVOT = 1e-15  # the least, where rows depend on each other


def damped_step(jacobian: np.ndarray, error: np.ndarray, damping: float) -> np.ndarray:
    """Give ``J^T (J J^T + damping I)^-1 error``.

    Args:
        jacobian: J, with at most as many rows as columns.  # (m, nv)
        error: What the step shall make.  # (m,)
        damping: Above 0 where the rows depend on each other.
    """
    square = jacobian.dot(jacobian.T)
    mujoco.mju_addToScl(square.ravel(), _flat_unit(len(square)), damping)
    solution = np.empty(len(error))
    mujoco.mju_cholFactor(square, _PIVOT)
    mujoco.mju_cholSolve(solution, square, error)
    return solution.dot(jacobian)  # (nv,)


def boxed_step(
    jacobian: np.ndarray,
    slope: np.ndarray,
    damping: float,
    least: np.ndarray,
    most: np.ndarray,
) -> np.ndarray:
    """Give the dq of a box for which ``|error + J dq|^2 + damping |dq|^2`` is least.

    By it ``|error + J dq|^2`` is less than ``|error|^2`` by at least ``-slope dq``, and by no
    more without damping and box.

    Args:
        jacobian: J.  # (m, nv)
        slope: ``J^T error``.  # (nv,)
        damping: Above 0.
        least: The box, which nought lies in.  # (nv,)
        most: The box.  # (nv,)
    """
    nv = len(least)
    square = jacobian.T.dot(jacobian)
    mujoco.mju_addToScl(square.ravel(), _flat_unit(nv), damping + _ROUND)
    if damping < _FINE:
        # MuJoCo takes a slope of less than 1e-8 for none.
        square /= damping
        slope = slope / damping
    dq = np.zeros(nv)  # stays inside the box where the solver fails
    mujoco.mju_boxQP(dq, np.empty((nv, nv + 7)), None, square, slope, least, most)
    return dq


@cache
def _flat_unit(n: int) -> np.ndarray:
    return np.eye(n).ravel()
