"""From a solution to a better one, along what its constraints leave free."""

from typing import NamedTuple

import eigenpy
import numpy as np

from .descent import descend
from .secondary_objectives import Expansion, SecondaryObjectives
from .system import System

STEPS = 40
RESTORING = 8  # steps of the descent back onto the constraints
LEASH = 0.8  # [rad] that a joint moves by in one step
_HOLDINGS = 3  # times that joints are held before a step is taken as it is
_SOFTER, _HARDER, _HARDEST = 0.3, 4.0, 1e4
_DAMPED = 0.5  # of the largest curvature, after the first step that does not keep its promise
_LITTLE, _MUCH = 0.4, 0.9  # of what a step promised, that it gained
_ENOUGH = 1e-4  # of the cost, that a step has to promise to be worth it
_ROUND, _LEAST = 1e-10, 1e-12  # relative and absolute, against rounding


class RefinementResult(NamedTuple):
    """Where an improvement ended: configuration, its cost, steps."""

    q: np.ndarray
    cost: float
    iterations: int


def improve(
    system: System,
    preferences: SecondaryObjectives,
    q: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> RefinementResult:
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
    if system.q is not q:
        system.look(q)
    here, jacobian = preferences.expand(system), system.jacobian()
    damping, steps = 0.0, 0
    while steps < STEPS and damping <= _HARDEST:
        steps += 1
        dq = _step(here, jacobian, q, damping, lower, upper)
        promised = -float(dq.dot(here.gradient + 0.5 * here.curvature.dot(dq)))
        if promised <= _ENOUGH * max(abs(here.value), _LEAST):
            break
        back = descend(system, q + dq, lower, upper, iterations=RESTORING)
        steps += back.iterations
        there = preferences.expand(system) if back.solved else None
        gained = -np.inf if there is None else here.value - there.value
        if gained < _LITTLE * promised:
            damping = max(_DAMPED, _HARDER * damping)
        elif gained > _MUCH * promised:
            damping *= _SOFTER
        if there is not None and gained > 0.0:
            q, here, jacobian = back.q, there, system.jacobian()
    return RefinementResult(q, here.value, steps)


def _step(
    here: Expansion,
    jacobian: np.ndarray,
    q: np.ndarray,
    damping: float,
    lower: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray:
    """Give the step to where the cost is least, inside what limits and leash allow.

    Joints that would go beyond are held where they may just go, and the step of the others found
    again.
    """
    curvature = here.curvature.copy()
    n, m = len(q), len(jacobian)
    largest = max(float(curvature.ravel()[:: n + 1].max()), _LEAST)
    curvature.ravel()[:: n + 1] += max(damping, _ROUND) * largest
    least, most = np.maximum(lower - q, -LEASH), np.minimum(upper - q, LEASH)
    gradient, missing = here.gradient, np.zeros(m)
    held, fixed = np.zeros(n, dtype=bool), np.zeros(n)
    for _ in range(_HOLDINGS):
        # Without constraints the step is w = -H^-1 g. What they would lose by it is made up for
        # where that costs least: w - H^-1 J^T (J H^-1 J^T)^-1 J w.
        inverse = eigenpy.LLT(curvature)
        dq = -inverse.solve(gradient)
        if m:
            across = inverse.solve(np.asfortranarray(jacobian.T))
            square = jacobian.dot(across)
            square.ravel()[:: m + 1] += _ROUND * float(square.trace()) + _LEAST
            dq -= across.dot(eigenpy.LLT(square).solve(jacobian.dot(dq) + missing))
        dq += fixed
        beyond = ((dq < least) | (dq > most)) & ~held
        if not beyond.any():
            break
        stop = np.minimum(np.maximum(dq, least), most) * beyond
        held, fixed = held | beyond, fixed + stop
        gradient = (gradient + curvature.dot(stop)) * ~held
        missing = missing + jacobian.dot(stop)
        jacobian = jacobian * ~held
        curvature[beyond] = 0.0
        curvature[:, beyond] = 0.0
        curvature[beyond, beyond] = largest
    return np.minimum(np.maximum(dq, least), most)
