"""Refinement of a solution: reduction of its cost subject to its constraints."""

from typing import NamedTuple

import eigenpy
import numpy as np

from .levenberg_marquardt import levenberg_marquardt
from .residuals import StackedResidual
from .secondary_objectives import QuadraticModel, SecondaryObjectives

MAX_REFINEMENT_STEPS = 40
PROJECTION_ITERATIONS = 8  # of Levenberg-Marquardt, to project a step onto the constraints
MAX_JOINT_STEP = 0.8  # [rad]
_ACTIVE_SET_PASSES = 3  # each fixes joints at a bound and recomputes the step of the others
_REDUCE, _INCREASE, _MAX_DAMPING = 0.3, 4.0, 1e4  # damping relative to the largest curvature
_FIRST_DAMPING = 0.5  # after the first step with a poor reduction of the cost
_POOR, _GOOD = 0.4, 0.9  # ratio of actual and predicted reduction of the cost
_MIN_REDUCTION = 1e-4  # predicted reduction of the cost below which the refinement ends
_RELATIVE, _ABSOLUTE = 1e-10, 1e-12  # regularization of the factorizations


class RefinementResult(NamedTuple):
    """Result of a refinement: the configuration, its cost, and the number of iterations."""

    q: np.ndarray
    cost: float
    iterations: int


def refine(
    constraints: StackedResidual,
    objectives: SecondaryObjectives,
    q: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> RefinementResult:
    """Move a solution to a local minimum of the cost, subject to the constraints.

    Each step is a damped Newton step on the cost subject to the linearized constraints (sequential
    quadratic programming), projected onto the constraints by Levenberg-Marquardt. It is accepted if
    it reduces the cost.

    Args:
        constraints: The constraints, met at `q`.
        objectives: The cost.
        q: The solution.  # (nq,)
        lower: Lower position limits.  # (nq,)
        upper: Upper position limits.  # (nq,)
    """
    if constraints.q is not q:
        constraints.evaluate(q)
    here, jacobian = objectives.expand(constraints), constraints.jacobian()
    damping, iterations = 0.0, 0
    while iterations < MAX_REFINEMENT_STEPS and damping <= _MAX_DAMPING:
        iterations += 1
        dq = _newton_step(here, jacobian, q, damping, lower, upper)
        predicted = -float(dq.dot(here.gradient + 0.5 * here.hessian.dot(dq)))
        if predicted <= _MIN_REDUCTION * max(abs(here.value), _ABSOLUTE):
            break
        projected = levenberg_marquardt(
            constraints, q + dq, lower, upper, iterations=PROJECTION_ITERATIONS
        )
        iterations += projected.iterations
        there = objectives.expand(constraints) if projected.solved else None
        actual = -np.inf if there is None else here.value - there.value
        if actual < _POOR * predicted:
            damping = max(_FIRST_DAMPING, _INCREASE * damping)
        elif actual > _GOOD * predicted:
            damping *= _REDUCE
        if there is not None and actual > 0.0:
            q, here, jacobian = projected.q, there, constraints.jacobian()
    return RefinementResult(q, here.value, iterations)


def _newton_step(
    here: QuadraticModel,
    jacobian: np.ndarray,
    q: np.ndarray,
    damping: float,
    lower: np.ndarray,
    upper: np.ndarray,
) -> np.ndarray:
    """Return the damped Newton step inside the limits and `MAX_JOINT_STEP`.

    Joints that would leave these bounds are fixed there, and the step of the others is recomputed.
    """
    hessian = here.hessian.copy()
    n, m = len(q), len(jacobian)
    largest = max(float(hessian.ravel()[:: n + 1].max()), _ABSOLUTE)
    hessian.ravel()[:: n + 1] += max(damping, _RELATIVE) * largest
    least, most = np.maximum(lower - q, -MAX_JOINT_STEP), np.minimum(upper - q, MAX_JOINT_STEP)
    gradient, violation = here.gradient, np.zeros(m)
    active, fixed = np.zeros(n, dtype=bool), np.zeros(n)
    for _ in range(_ACTIVE_SET_PASSES):
        # w = -H^-1 g without constraints; with them w - H^-1 J^T (J H^-1 J^T)^-1 J w.
        inverse = eigenpy.LLT(hessian)
        dq = -inverse.solve(gradient)
        if m:
            inverse_transposed = inverse.solve(np.asfortranarray(jacobian.T))
            square = jacobian.dot(inverse_transposed)
            square.ravel()[:: m + 1] += _RELATIVE * float(square.trace()) + _ABSOLUTE
            dq -= inverse_transposed.dot(eigenpy.LLT(square).solve(jacobian.dot(dq) + violation))
        dq += fixed
        beyond = ((dq < least) | (dq > most)) & ~active
        if not beyond.any():
            break
        bound = np.minimum(np.maximum(dq, least), most) * beyond
        active, fixed = active | beyond, fixed + bound
        gradient = (gradient + hessian.dot(bound)) * ~active
        violation = violation + jacobian.dot(bound)
        jacobian = jacobian * ~active
        hessian[beyond] = 0.0
        hessian[:, beyond] = 0.0
        hessian[beyond, beyond] = largest
    return np.minimum(np.maximum(dq, least), most)
