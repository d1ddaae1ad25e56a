"""Shortcutting and smoothing of paths."""

import numpy as np
import pytest

from bt_manip.planning import edge_is_free, shortcut
from bt_manip.planning.path_simplification import smooth_paths


def beside_the_wall(q, inside=0.0) -> bool:
    """Tell whether a point is outside a wall that reaches from below up to 1 rad."""
    return not (abs(q[0]) < 0.2 - inside and q[1] < 1.0 - inside)


def test_shortcuts_remove_detours_and_keep_the_ends():
    detour = np.array([[-1.0, 0.0], [-1.5, 1.8], [0.0, 1.9], [1.9, 1.9], [1.0, 0.0]])
    best = 0.4 + 2 * np.hypot(0.8, 1.0)  # around both corners of the wall
    lengths = []
    for seed in range(12):
        short = shortcut(detour, beside_the_wall, np.random.default_rng(seed))
        assert np.array_equal(short[[0, -1]], detour[[0, -1]])
        lengths.append(np.linalg.norm(np.diff(short, axis=0), axis=1).sum())
        for a, b in zip(short, short[1:], strict=False):
            assert edge_is_free(a, b, lambda q: beside_the_wall(q, 0.015), 0.01)
    assert best - 1e-9 <= min(lengths) and np.median(lengths) <= 1.07 * best
    for n in (3, 5):  # where nothing blocks it, the straight line is left
        straight = shortcut(detour[:n], lambda q: True, np.random.default_rng(0))
        assert np.array_equal(straight, detour[[0, n - 1]])


def test_smooth_paths_keep_the_ends_and_approach_the_corners():
    corner = np.array([[0.31, -2.0], [1.31, -1.0], [2.31, -2.0]])
    heights = []
    for path in smooth_paths(corner):
        q, slope, bend = path.evaluate(np.linspace(0.0, 1.0, 501))
        assert np.array_equal(path.knots[[0, -1]], corner[[0, -1]])
        assert np.allclose(q[[0, -1]], corner[[0, -1]], atol=1e-9)
        assert np.abs(np.diff(slope, axis=0)).max() < 0.5  # no corner is left
        assert np.abs(bend[[0, -1]]).max() < 1e-2  # and it is straight at its ends
        heights.append(q[:, 1].max())
    # A corner of 90 degrees is averaged with the sum of four uniform offsets, of 7/15 of a window
    # on average. The windows are a quarter of 0.5, 0.3, 0.18, 0.1 and 0.06 of 384, rounded to odd.
    windows = np.array([49, 29, 19, 11, 7]) / 384
    assert heights == pytest.approx((-1.0 - 7.0 / 15.0 * 2.0 * windows).tolist(), abs=5e-4)
