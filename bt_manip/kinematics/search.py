"""The searches for one task: from several starts, near one configuration, or for all there is."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from .descent import LMResult, descend
from .improvement import RefinementResult, improve
from .task import Task

PATIENCE = 15  # steps without progress, where there is no restart
PROMISE = 0.2  # of the squared error; where a step takes less, another start is worth more
_ROUND = 1e-12  # [rad]
DETOURS = 5  # starts elsewhere, where the first ends in a corner of the box
TRIES = 8  # starts of a task that has costs alone, of which the best end is taken


class Found(NamedTuple):
    """Where a search ended.

    Attributes:
        q: The solution, or what came nearest.  # (nq,)
        solved: Which of both it is.
        iterations: Steps taken, over all starts.
        restarts: How many starts after the first.
        reason: Why it is not solved; empty when it is.
        cost: What it costs, where something does.
    """

    q: np.ndarray
    solved: bool
    iterations: int = 0
    restarts: int = 0
    reason: str = ""
    cost: float = 0.0


def search(task: Task, starts: Iterable[np.ndarray], iterations: int, steps_in_vain: int) -> Found:
    """Search from one start after the other until a solution is found.

    Args:
        task: What is searched for.
        starts: At least one configuration inside the limits.  # (nq,) each
        iterations: Steps from each start, at the most.
        steps_in_vain: Steps that led to no solution, over all starts, after which no other begins.
    """
    wanted = 1 if task.system.rows else TRIES
    found: list[RefinementResult] = []
    best: LMResult | None = None
    blocked = ""
    steps, vain, count = 0, 0, -1
    for begin in starts:
        count += 1
        end = descend(
            task.system,
            begin,
            task.lower,
            task.upper,
            iterations=iterations,
            promise=PROMISE if count else 0.0,
        )
        steps += end.iterations
        vain += 0 if end.solved else end.iterations
        obstacle = task.blocked(end.q) if end.solved else ""
        if end.solved and not obstacle:
            found.append(improved(task, end, task.lower, task.upper))
            steps += found[-1].iterations
            if len(found) == wanted:
                break
        elif best is None or (not end.solved, end.error) < (not best.solved, best.error):
            best, blocked = end, obstacle
        if vain >= steps_in_vain:
            break
    if found:
        least = min(found, key=lambda improved: improved.cost)
        return Found(least.q, True, steps, count, cost=least.cost)
    assert best is not None
    what = "free solution" if best.solved else "solution"
    why = f": {blocked}" if best.solved else ""
    return Found(best.q, False, steps, count, f"no {what} from {count + 1} starts{why}")


def search_near(
    task: Task, q0: np.ndarray, iterations: int, *, max_step: float, detours: bool
) -> Found:
    """Search inside a box around a configuration.

    Args:
        task: What is searched for; limits that `q0` is beyond are not held against it.
        q0: The middle of the box.  # (nq,)
        iterations: Steps from each start, at the most.
        max_step: Half the sides of the box [rad].
        detours: Whether to try again from elsewhere inside the box.
    """
    lower, upper = np.minimum(task.lower, q0), np.maximum(task.upper, q0)
    least, most = np.maximum(lower, q0 - max_step), np.minimum(upper, q0 + max_step)
    steps, end = 0, None
    for start in _inside(q0, least, most) if detours else (q0,):
        last = descend(task.system, start, least, most, iterations=iterations, patience=PATIENCE)
        steps += last.iterations
        if end is None or last.solved or last.error < end.error:
            end = last
        if end.solved:
            break
    assert end is not None
    if end.solved:
        better = improved(task, end, least, most)
        blocked = task.blocked(better.q)
        return Found(better.q, not blocked, steps + better.iterations, 0, blocked, better.cost)
    at_limit = ((end.q <= lower + _ROUND) | (end.q >= upper - _ROUND)) & (lower < upper)
    names = [task.joints[i] for i in np.flatnonzero(at_limit).tolist()]
    if names:
        reason = f"{' and '.join(names)} at the limit"
    elif np.abs(end.q - q0).max() >= max_step - _ROUND:
        reason = f"a joint would have to jump by more than {max_step:g} rad"
    else:
        reason = "out of reach, or singular"
    return Found(end.q, False, steps, reason=reason)


def search_all(task: Task, starts: Iterable[np.ndarray], iterations: int) -> list[Found]:
    """Search from all starts, and give the free solutions, whichever are the same too.

    Args:
        task: What is searched for.
        starts: Configurations inside the limits.  # (nq,) each
        iterations: Steps from each start, at the most.
    """
    found = []
    for begin in starts:
        end = descend(task.system, begin, task.lower, task.upper, iterations=iterations)
        if end.solved:
            better = improved(task, end, task.lower, task.upper)
            if not task.blocked(better.q):
                steps = end.iterations + better.iterations
                found.append(Found(better.q, True, steps, cost=better.cost))
    return found


def improved(task: Task, end: LMResult, lower: np.ndarray, upper: np.ndarray) -> RefinementResult:
    """Move a solution to where it costs least, unless it would touch something there."""
    if task.preferences is None:
        return RefinementResult(end.q, 0.0, 0)
    better = improve(task.system, task.preferences, end.q, lower, upper)
    if task.blocked(better.q):
        return RefinementResult(end.q, task.cost(end.q), better.iterations)
    return better


def _inside(q0: np.ndarray, least: np.ndarray, most: np.ndarray) -> Iterator[np.ndarray]:
    """Give the middle of a box, and then starts anywhere in it, the same each time."""
    yield q0
    yield from np.random.default_rng(0).uniform(least, most, (DETOURS, len(q0)))
