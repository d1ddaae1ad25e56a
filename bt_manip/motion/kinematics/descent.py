"""Levenberg-Marquardt from one start to one solution: the inner loop of inverse kinematics."""

from typing import NamedTuple

import numpy as np

from .least_squares import damped_step
from .system import System

DAMPING = 0.03  # of the squared error
STALL_STEPS = 4  # that do not bring the error below STALL_FACTOR of the least end a descent
STALL_FACTOR = 0.9


class Descended(NamedTuple):
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
) -> Descended:
    """Descend from a configuration inside the limits to the nearest solution downhill.

    A joint at its limit that would leave it is held, and the step taken with the others.

    Args:
        system: What has to be met.
        q: Where to start.  # (nq,)
        lower: Limits of the positions.  # (nq,)
        upper: Limits of the positions.  # (nq,)
        iterations: Steps at the most.
        patience: Steps without progress that end the descent.
    """
    best, stalled, best_q = np.inf, 0, q
    for step in range(iterations + 1):
        met = system.look(q)
        error = system.error
        square = float(error.dot(error))
        norm = square**0.5
        if met:
            return Descended(q, norm, step, True)
        if norm < best:
            best_q = q
        if norm < STALL_FACTOR * best:
            stalled = 0
        else:
            stalled += 1
            if stalled >= patience:
                break
        best = min(best, norm)
        jacobian = system.jacobian()
        dq = damped_step(jacobian, error, DAMPING * square)
        moved = q + dq
        inside = np.minimum(np.maximum(moved, lower), upper)
        if inside.tolist() != moved.tolist():  # faster than comparing short arrays
            held = ((q <= lower) & (dq < 0.0)) | ((q >= upper) & (dq > 0.0))
            if held.any():
                moved = q + damped_step(jacobian * ~held, error, DAMPING * square + 1e-12)
                inside = np.minimum(np.maximum(moved, lower), upper)
        q = inside
    return Descended(best_q, min(best, norm), step, False)
