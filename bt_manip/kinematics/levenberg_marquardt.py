"""The Levenberg-Marquardt algorithm within joint limits, from one initial guess."""

from typing import NamedTuple

import mujoco
import numpy as np

from .residuals import StackedResidual

DAMPING = 0.03  # damping relative to the squared residual
STALL_ITERATIONS = 4  # iterations without a residual below STALL_FACTOR times the smallest
STALL_FACTOR = 0.9
_BOX_WIDTH = 1e-12  # [rad] minimum range of a joint for the box solver
_DIAGONAL = 1e-12  # regularization of the normal equations, above rounding errors
_STATIONARY = 1e-2  # [m/rad] decrease of the residual's norm below which q is stationary
_SCALED_DAMPING = 1e-10  # damping below which the normal equations are scaled


class LMResult(NamedTuple):
    """Result of Levenberg-Marquardt.

    Attributes:
        q: The configuration with the smallest residual, inside the limits.  # (nq,)
        error: Norm of the residual.
        iterations: Number of iterations.
        solved: Whether the targets are reached, or met as closely as the joints allow.
        met: Whether the targets are met.
    """

    q: np.ndarray
    error: float
    iterations: int
    solved: bool
    met: bool


def levenberg_marquardt(
    residual: StackedResidual,
    q: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    *,
    iterations: int,
    patience: int = STALL_ITERATIONS,
    min_decrease: float = 0.0,
) -> LMResult:
    """Minimize a residual inside the limits until its targets are reached.

    Each step minimizes the damped linearized residual inside the limits. The damping is
    proportional to the squared residual (Sugihara, Solvability-Unconcerned Inverse Kinematics by
    the Levenberg-Marquardt Method, 2011).

    Args:
        residual: The residual.
        q: The initial guess.  # (nq,)
        lower: Lower position limits.  # (nq,)
        upper: Upper position limits.  # (nq,)
        iterations: Maximum number of steps.
        patience: Iterations without progress after which the search ends.
        min_decrease: Minimum relative decrease of the squared residual by a step, to first order,
            below which the search ends, unless the targets may be met already.
    """
    least_error, stalled, best_q = np.inf, 0, q
    squared_bound = residual.squared_bound
    box_upper = np.maximum(upper, lower + _BOX_WIDTH)
    for iteration in range(iterations + 1):
        error = residual.evaluate(q)
        squared = float(error.dot(error))
        norm = squared**0.5
        if squared <= squared_bound and residual.reached:
            inside = np.minimum(np.maximum(q, lower), upper)  # despite rounding
            exact = inside.tolist() == q.tolist()
            return LMResult(q if exact else inside, norm, iteration, True, True)
        stalled = 0 if norm < STALL_FACTOR * least_error else stalled + 1
        if norm < least_error:
            least_error, best_q = norm, q
        if stalled >= patience:
            break
        jacobian = residual.jacobian()
        gradient = error.dot(jacobian)
        dq = _box_step(jacobian, gradient, DAMPING * squared, lower - q, box_upper - q)
        decrease = -float(gradient.dot(dq))
        if decrease < min_decrease * squared and squared > residual.accepted_bound:
            break
        q = q + dq
    q = np.minimum(np.maximum(best_q, lower), upper)
    met, solved = False, False
    if least_error * least_error <= residual.accepted_bound:
        error = residual.evaluate(q)
        met = residual.met
        gradient = error.dot(residual.jacobian())
        solved = met and float(np.linalg.norm(gradient)) <= _STATIONARY * least_error
    return LMResult(q, least_error, iteration, solved, met)


def _box_step(
    jacobian: np.ndarray,
    gradient: np.ndarray,
    damping: float,
    lower: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray:
    """Return the dq in a box that minimizes ``|error + J dq|^2 + damping |dq|^2``.

    Args:
        jacobian: J.  # (m, nv)
        gradient: ``J^T error``.  # (nv,)
        damping: Above 0.
        lower: Lower bounds of dq, at most 0.  # (nv,)
        upper: Upper bounds of dq, at least 0.  # (nv,)
    """
    nv = len(lower)
    hessian = jacobian.T.dot(jacobian)
    hessian.ravel()[:: nv + 1] += damping + _DIAGONAL
    if damping < _SCALED_DAMPING:
        # MuJoCo treats gradients below 1e-8 as zero.
        hessian /= damping
        gradient = gradient / damping
    dq = np.zeros(nv)  # unchanged if the solver fails
    mujoco.mju_boxQP(dq, np.empty((nv, nv + 7)), None, hessian, gradient, lower, upper)
    return dq
