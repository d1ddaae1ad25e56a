"""Searches for solutions: from several initial guesses, near a configuration, or for all."""

from collections.abc import Iterable, Iterator

import numpy as np

from .compiled_problem import CompiledProblem
from .levenberg_marquardt import LMResult, levenberg_marquardt
from .problem import IKResult
from .refinement import RefinementResult, refine

ITERATIONS = 50  # maximum number from each initial guess
MAX_FAILED_ITERATIONS = 600  # total number of iterations after which there are no more restarts
NEAR_PATIENCE = 15  # iterations without progress, in searches without restarts
MIN_DECREASE = 0.2  # decrease of the squared residual by a step below which a restart is better
NEAR_RESTARTS = 5  # further initial guesses inside the box
COST_GUESSES = 8  # initial guesses for a problem without constraints; the best result is used
_AT_BOUND = 1e-12  # [rad]


def search(problem: CompiledProblem, guesses: Iterable[np.ndarray]) -> IKResult:
    """Search from one initial guess after the other, up to the first solution.

    Args:
        problem: The problem.
        guesses: At least one configuration inside the limits.  # (nq,) each
    """
    wanted = 1 if problem.constraints.parts else COST_GUESSES
    found: list[RefinementResult] = []
    best: LMResult | None = None
    nearly: LMResult | None = None  # met, not reached
    collision = ""
    total, failed, restarts = 0, 0, -1
    for guess in guesses:
        restarts += 1
        end = levenberg_marquardt(
            problem.constraints,
            guess,
            problem.lower,
            problem.upper,
            iterations=ITERATIONS,
            min_decrease=MIN_DECREASE if restarts else 0.0,
        )
        total += end.iterations
        failed += 0 if end.solved else end.iterations
        touching = problem.collision(end.q) if end.solved else ""
        if end.solved and not touching:
            found.append(_refine(problem, end, problem.lower, problem.upper))
            total += found[-1].iterations
            if len(found) == wanted:
                break
        elif best is None or (not end.solved, end.error) < (not best.solved, best.error):
            best, collision = end, touching
        if end.met and not end.solved and (nearly is None or end.error < nearly.error):
            nearly = end if not problem.collision(end.q) else nearly
        if failed >= MAX_FAILED_ITERATIONS:
            break
    if found:
        least = min(found, key=lambda refined: refined.cost)
        errors = problem.errors(least.q)
        return IKResult(least.q, True, errors, total, restarts, cost=least.cost)
    if nearly is not None:
        errors, cost = problem.errors(nearly.q), problem.cost(nearly.q)
        return IKResult(nearly.q, True, errors, total, restarts, cost=cost)
    assert best is not None
    reason = f"no solution from {restarts + 1} initial guesses"
    if best.solved:
        reason = f"no collision-free solution from {restarts + 1} initial guesses: {collision}"
    return IKResult(best.q, False, problem.errors(best.q), total, restarts, reason)


def search_near(
    problem: CompiledProblem, q0: np.ndarray, *, max_step: float, retry: bool
) -> IKResult:
    """Search inside a box around a configuration.

    Args:
        problem: The problem; a limit that `q0` violates is widened to `q0`.
        q0: The centre of the box.  # (nq,)
        max_step: Half the sides of the box [rad].
        retry: Whether to use further initial guesses inside the box.
    """
    lower, upper = np.minimum(problem.lower, q0), np.maximum(problem.upper, q0)
    least, most = np.maximum(lower, q0 - max_step), np.minimum(upper, q0 + max_step)
    total, best = 0, None
    for guess in _guesses_inside(q0, least, most) if retry else (q0,):
        end = levenberg_marquardt(
            problem.constraints, guess, least, most, iterations=ITERATIONS, patience=NEAR_PATIENCE
        )
        total += end.iterations
        if best is None or end.solved or end.error < best.error:
            best = end
        if end.solved:
            break
    assert best is not None
    if best.met:
        refined = _refine(problem, best, least, most)
        touching = problem.collision(refined.q)
        total += refined.iterations
        errors = problem.errors(refined.q)
        return IKResult(refined.q, not touching, errors, total, 0, touching, cost=refined.cost)
    at_limit = ((best.q <= lower + _AT_BOUND) | (best.q >= upper - _AT_BOUND)) & (lower < upper)
    names = [problem.joints[i] for i in np.flatnonzero(at_limit).tolist()]
    if names:
        reason = f"{' and '.join(names)} at the limit"
    elif np.abs(best.q - q0).max() >= max_step - _AT_BOUND:
        reason = f"a joint would have to jump by more than {max_step:g} rad"
    else:
        reason = "out of reach, or singular"
    return IKResult(best.q, False, problem.errors(best.q), total, reason=reason)


def search_all(problem: CompiledProblem, guesses: Iterable[np.ndarray]) -> list[LMResult]:
    """Return all results from initial guesses that meet the constraints, duplicates included.

    Args:
        problem: The problem.
        guesses: Configurations inside the limits.  # (nq,) each
    """
    limits = problem.lower, problem.upper
    ends = [
        levenberg_marquardt(problem.constraints, guess, *limits, iterations=ITERATIONS)
        for guess in guesses
    ]
    solved = any(end.solved for end in ends)
    return [end for end in ends if end.solved or (end.met and not solved)]


def refined_end(problem: CompiledProblem, end: LMResult) -> IKResult | None:
    """Return a refined result of `search_all`; None if it collides."""
    refined = _refine(problem, end, problem.lower, problem.upper)
    if problem.collision(refined.q):
        return None
    total, errors = end.iterations + refined.iterations, problem.errors(refined.q)
    return IKResult(refined.q, True, errors, total, cost=refined.cost)


def _refine(
    problem: CompiledProblem, end: LMResult, lower: np.ndarray, upper: np.ndarray
) -> RefinementResult:
    """Refine a solution, unless the refined solution collides."""
    if problem.objectives is None:
        return RefinementResult(end.q, 0.0, 0)
    refined = refine(problem.constraints, problem.objectives, end.q, lower, upper)
    if problem.collision(refined.q):
        return RefinementResult(end.q, problem.cost(end.q), refined.iterations)
    return refined


def _guesses_inside(q0: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the centre of a box, and then a fixed sequence of points inside."""
    yield q0
    yield from np.random.default_rng(0).uniform(lower, upper, (NEAR_RESTARTS, len(q0)))
