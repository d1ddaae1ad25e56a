"""Shortcutting and smoothing of planned paths."""

from collections.abc import Iterator

import numpy as np

from bt_manip.trajectories import Path, SplinePath, StraightPath

from .joint_segments import IsFree, edge_is_free

SHORTCUTS = 120  # attempts
EDGE_STEP = 0.02  # [rad] between the configurations that are checked on a shortcut
MIN_SAVING = 5e-3  # share of the path length; shortcuts that save less are not checked
MIN_SEGMENT = 1e-6  # [rad]
KERNEL_WIDTHS = (0.5, 0.3, 0.18, 0.1, 0.06)  # share of the path length
SPLINE_INTERVALS = 96
SAMPLES_PER_INTERVAL = 4
AVERAGES = 4  # passes of a moving average: their kernel is a cubic B-spline


def shortcut(path: np.ndarray, is_free: IsFree, rng: np.random.Generator) -> np.ndarray:
    """Shorten a path by replacing parts of it with collision-free segments.

    Args:
        path: Waypoints.  # (n, nq)
        is_free: Tells whether a configuration is collision-free.
        rng: Draws the ends of the shortcuts.
    """  # (m, nq)
    path = _prune(path, is_free)
    along = _arc_lengths(path)
    for _ in range(SHORTCUTS):
        if len(path) < 3:
            break
        # Long shortcuts remove detours, short ones cut corners.
        middle, half = rng.uniform(0.0, along[-1]), 0.5 * along[-1] * rng.uniform() ** 3
        first, last = max(0.0, middle - half), min(float(along[-1]), middle + half)
        i, j = (int(np.searchsorted(along, x, side="right")) - 1 for x in (first, last))
        j = min(j, len(path) - 2)
        if i == j:
            continue
        a, b = _interpolate(path, along, first, i), _interpolate(path, along, last, j)
        saving = last - first - float(np.linalg.norm(b - a))
        if saving >= MIN_SAVING * along[-1] and edge_is_free(a, b, is_free, EDGE_STEP):
            path = _without_duplicates(np.vstack([path[: i + 1], a, b, path[j + 1 :]]))
            along = _arc_lengths(path)
    return _prune(path, is_free)


def smooth_paths(waypoints: np.ndarray) -> Iterator[Path]:
    """Yield smooth paths along waypoints, from the widest to the tightest corners.

    The polyline is averaged along its length with a B-spline kernel: the result stays inside the
    convex hull of what is averaged, and straight parts longer than the kernel stay straight. The
    polyline is extended beyond its ends by point reflection, which keeps the ends.

    Args:
        waypoints: At least two, connected by straight segments.  # (n, nq)
    """
    if len(waypoints) == 2:
        yield StraightPath(waypoints[0], waypoints[1])
        return
    n = SPLINE_INTERVALS * SAMPLES_PER_INTERVAL
    along = _arc_lengths(waypoints)
    samples = np.linspace(0.0, along[-1], n + 1)
    polyline = np.column_stack([np.interp(samples, along, q) for q in waypoints.T])
    for width in KERNEL_WIDTHS:
        half = max(1, round(width * n / (2 * AVERAGES)))
        smooth = polyline
        for _ in range(AVERAGES):
            smooth = _moving_average(smooth, half)
        smooth[0], smooth[-1] = waypoints[0], waypoints[-1]
        yield SplinePath(smooth[::SAMPLES_PER_INTERVAL])


def _prune(path: np.ndarray, is_free: IsFree) -> np.ndarray:
    """Connect each waypoint with the last one that it can reach on a straight segment."""
    kept = [0]
    while kept[-1] < len(path) - 1:
        i = kept[-1]
        later = range(len(path) - 1, i + 1, -1)
        reached = (k for k in later if edge_is_free(path[i], path[k], is_free, EDGE_STEP))
        kept.append(next(reached, i + 1))
    return path[kept]


def _arc_lengths(path: np.ndarray) -> np.ndarray:
    """Return the length of the path up to each waypoint [rad]."""  # (n,)
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])


def _interpolate(path: np.ndarray, along: np.ndarray, x: float, i: int) -> np.ndarray:
    part = (x - along[i]) / (along[i + 1] - along[i])
    return path[i] + part * (path[i + 1] - path[i])


def _without_duplicates(path: np.ndarray) -> np.ndarray:
    apart = np.linalg.norm(np.diff(path, axis=0), axis=1) > MIN_SEGMENT
    kept = path[np.concatenate([[True], apart])]
    kept[-1] = path[-1]  # exactly
    return kept


def _moving_average(rows: np.ndarray, half: int) -> np.ndarray:
    """Average over windows of ``2 half + 1`` rows."""
    before = 2.0 * rows[0] - rows[half:0:-1]
    behind = 2.0 * rows[-1] - rows[-2 : -half - 2 : -1]
    total = np.cumsum(np.vstack([np.zeros_like(rows[:1]), before, rows, behind]), axis=0)
    window = 2 * half + 1
    return (total[window:] - total[:-window]) / window
