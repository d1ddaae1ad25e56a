"""Make a path smooth: its corners are rounded, its ends stay."""

from collections.abc import Iterator

import numpy as np

from bt_manip.trajectories import Path, SplinePath, StraightPath

WIDTHS = (0.5, 0.3, 0.18, 0.1, 0.06)  # of the longest rounding, in parts of the path
KNOTS = 96  # intervals of the spline
FINE = 4  # samples per interval that are averaged
PASSES = 4  # of a moving average: the kernel is a cubic B-spline


def smooth_paths(waypoints: np.ndarray) -> Iterator[Path]:
    """Give smooth paths along waypoints, from the widest corners to the tightest.

    The polyline is averaged along its length with a B-spline kernel, which stays inside the convex
    hull of what it averages; straight parts longer than the kernel stay straight. Behind its ends
    the polyline is continued by its own point reflection, so that the ends stay where they are.

    Args:
        waypoints: At least two, with straight lines between them.  # (n, nq)
    """
    if len(waypoints) == 2:
        yield StraightPath(waypoints[0], waypoints[1])
        return
    n = KNOTS * FINE
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1))])
    places = np.linspace(0.0, along[-1], n + 1)
    line = np.column_stack([np.interp(places, along, q) for q in waypoints.T])
    for width in WIDTHS:
        half = max(1, round(width * n / (2 * PASSES)))
        smooth = line
        for _ in range(PASSES):
            smooth = _averaged(smooth, half)
        smooth[0], smooth[-1] = waypoints[0], waypoints[-1]
        yield SplinePath(smooth[::FINE])


def _averaged(line: np.ndarray, half: int) -> np.ndarray:
    """Average over a window of ``2 half + 1`` samples."""
    before = 2.0 * line[0] - line[half:0:-1]
    behind = 2.0 * line[-1] - line[-2 : -half - 2 : -1]
    total = np.cumsum(np.vstack([np.zeros_like(line[:1]), before, line, behind]), axis=0)
    window = 2 * half + 1
    return (total[window:] - total[:-window]) / window
