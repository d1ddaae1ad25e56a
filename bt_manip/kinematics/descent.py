"""Levenberg-Marquardt from one start to one solution: the inner loop of inverse kinematics."""

from typing import NamedTuple

import numpy as np

from .least_squares import boxed_step
from .system import System

DAMPING = 0.03  # of the squared error
STALL_STEPS = 4  # that do not bring the error below STALL_FACTOR of the least end a descent
STALL_FACTOR = 0.9
_ROOM = 1e-12  # [rad] that the solver needs for a joint that has none


class LMResult(NamedTuple):
    """Where a descent ended: configuration, norm of the error, steps."""

    q: np.ndarray
    error: float
    iterations: int
    solved: bool


def descend(
    system: System,
    q: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    *,
    iterations: int,
    patience: int = STALL_STEPS,
    promise: float = 0.0,
) -> LMResult:
    """Descend from a configuration inside the limits to the nearest solution downhill.

    Each step is the best of those that do not leave the limits.

    Args:
        system: What has to be met.
        q: Where to start.  # (nq,)
        lower: Limits of the positions.  # (nq,)
        upper: Limits of the positions.  # (nq,)
        iterations: Steps at the most.
        patience: Steps without progress that end the descent.
        promise: Part of the squared error that every step shall take away to first order; one
            that would take less ends the descent.
    """
    best, stalled, best_q = np.inf, 0, q
    near = system.near
    most = np.maximum(upper, lower + _ROOM)
    for step in range(iterations + 1):
        error = system.look(q)
        square = float(error.dot(error))
        norm = square**0.5
        if square <= near and system.met:
            inside = np.minimum(np.maximum(q, lower), upper)  # to the last bit
            exact = inside.tolist() == q.tolist()
            return LMResult(q if exact else inside, norm, step, True)
        stalled = 0 if norm < STALL_FACTOR * best else stalled + 1
        if norm < best:
            best, best_q = norm, q
        if stalled >= patience:
            break
        damping = DAMPING * square
        jacobian = system.jacobian()
        slope = error.dot(jacobian)
        dq = boxed_step(jacobian, slope, damping, lower - q, most - q)
        if promise and -float(slope.dot(dq)) < promise * square:
            break
        q = q + dq
    return LMResult(np.minimum(np.maximum(best_q, lower), upper), best, step, False)
