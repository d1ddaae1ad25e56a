"""Make a path shorter by straight lines across it."""

import numpy as np

from .edges import Free, edge_is_free

TRIES = 120
STEP = 0.02  # [rad] between the configurations that are looked at
WORTH = 5e-3  # of the path's length, that a cut saves: others are not looked at
_LEAST = 1e-6  # [rad]


def shortcut(
    path: np.ndarray, free: Free, rng: np.random.Generator, *, tries: int = TRIES
) -> np.ndarray:
    """Replace parts of a path by straight lines where those are free.

    Args:
        path: Waypoints.  # (n, nq)
        free: Tells of a configuration whether it is free.
        rng: Chooses the places.
        tries: How often.
    """  # (m, nq)
    path = _pruned(path, free)
    along = _lengths(path)
    for _ in range(tries):
        if len(path) < 3:
            break
        # Long cuts take detours away, short ones bring corners nearer to what they go around.
        middle, reach = rng.uniform(0.0, along[-1]), 0.5 * along[-1] * rng.uniform() ** 3
        first, last = max(0.0, middle - reach), min(float(along[-1]), middle + reach)
        i, j = (int(np.searchsorted(along, x, side="right")) - 1 for x in (first, last))
        if i == min(j, len(path) - 2):
            continue
        j = min(j, len(path) - 2)
        a, b = _at(path, along, first, i), _at(path, along, last, j)
        saved = last - first - float(np.linalg.norm(b - a))
        if saved >= WORTH * along[-1] and edge_is_free(a, b, free, STEP):
            path = _without_repeats(np.vstack([path[: i + 1], a, b, path[j + 1 :]]))
            along = _lengths(path)
    return _pruned(path, free)


def _pruned(path: np.ndarray, free: Free) -> np.ndarray:
    """Go from each waypoint straight to the last that can be reached from it."""
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        later = range(len(path) - 1, here + 1, -1)
        reached = (k for k in later if edge_is_free(path[here], path[k], free, STEP))
        kept.append(next(reached, here + 1))
    return path[kept]


def _lengths(path: np.ndarray) -> np.ndarray:
    """Give how far each waypoint is along the path [rad]."""  # (n,)
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])


def _at(path: np.ndarray, along: np.ndarray, x: float, i: int) -> np.ndarray:
    part = (x - along[i]) / (along[i + 1] - along[i])
    return path[i] + part * (path[i + 1] - path[i])


def _without_repeats(path: np.ndarray) -> np.ndarray:
    far = np.linalg.norm(np.diff(path, axis=0), axis=1) > _LEAST
    kept = path[np.concatenate([[True], far])]
    kept[-1] = path[-1]  # exactly
    return kept
