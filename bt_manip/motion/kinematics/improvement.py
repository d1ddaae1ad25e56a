"""From a solution to a better one, along what its constraints leave free."""

from typing import NamedTuple

import eigenpy
import numpy as np

from .descent import descend
from .preferences import Expansion, Preferences
from .system import System

STEPS = 40
RESTORING = 8  # steps of the descent back onto the constraints
LEASH = 0.6  # [rad] that a joint moves by in one step
_HOLDINGS = 3  # times that joints are held before a step is taken as it is
_SOFTER, _HARDER, _HARDEST = 0.2, 10.0, 1e6
_DAMPED = 1e-3  # of the largest curvature, after the first step that does not serve
_ENOUGH = 1e-4  # of the cost, that a step has to promise to be worth it
_ROUND, _LEAST = 1e-10, 1e-12  # relative and absolute, against rounding


class Improved(NamedTuple):
    """Where an improvement ended: configuration, its cost, steps."""

    q: np.ndarray
    cost: float
    iterations: int


def improve(
    system: System,
    preferences: Preferences,
    q: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> Improved:
    """Go from a solution to where the cost is least nearby, still a solution.

    Each step is Newton's on the cost with the constraints kept to first order, damped as by
    Levenberg and Marquardt, followed by a descent back onto them; it is taken where the cost is
    less there.

    Args:
        system: The constraints, met at `q`.
        preferences: The cost.
        q: Where to start.  # (nq,)
        lower: Limits of the positions.  # (nq,)
        upper: Limits of the positions.  # (nq,)
    """
    system.look(q)
    here, jacobian = preferences.expand(system), system.jacobian()
    damping, steps = 0.0, 0
    while steps < STEPS and damping <= _HARDEST:
        steps += 1
        dq = _step(here, jacobian, q, damping, lower, upper)
        promised = -float(dq.dot(here.gradient + 0.5 * here.curvature.dot(dq)))
        if promised <= _ENOUGH * max(abs(here.value), _LEAST):
            break
        moved = np.minimum(np.maximum(q + dq, lower), upper)
        back = descend(system, moved, lower, upper, iterations=RESTORING)
        steps += back.iterations
        there = preferences.expand(system) if back.solved else None
        if there is None or there.value >= here.value:
            damping = max(_DAMPED, _HARDER * damping)
            continue
        q, damping = back.q, _SOFTER * damping
        here, jacobian = there, system.jacobian()
    return Improved(q, here.value, steps)


def _step(
    here: Expansion,
    jacobian: np.ndarray,
    q: np.ndarray,
    damping: float,
    lower: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray:
    """Give the step to where the cost is least, as far as constraints, limits and leash allow."""
    curvature, gradient = here.curvature.copy(), here.gradient
    n, m = len(q), len(jacobian)
    largest = max(float(curvature.ravel()[:: n + 1].max()), _LEAST)
    curvature.ravel()[:: n + 1] += max(damping, _ROUND) * largest
    at_lower, at_upper = q <= lower, q >= upper
    held = np.zeros(n, dtype=bool)
    for _ in range(_HOLDINGS):
        # Without constraints the step is w = -H^-1 g. What they would lose by it is made up for
        # where that costs least: w - H^-1 J^T (J H^-1 J^T)^-1 J w.
        inverse = eigenpy.LLT(curvature)
        dq = -inverse.solve(gradient)
        if m:
            across = inverse.solve(np.asfortranarray(jacobian.T))
            square = jacobian.dot(across)
            square.ravel()[:: m + 1] += _ROUND * float(square.trace()) + _LEAST
            dq -= across.dot(eigenpy.LLT(square).solve(jacobian.dot(dq)))
        leaving = (at_lower & (dq < 0.0)) | (at_upper & (dq > 0.0))
        if not leaving.any():
            break
        held |= leaving
        jacobian, gradient = jacobian * ~held, gradient * ~held
        curvature[held] = 0.0
        curvature[:, held] = 0.0
        curvature[held, held] = largest
        dq[held] = 0.0
    return dq * min(1.0, LEASH / max(float(np.abs(dq).max()), _LEAST))
