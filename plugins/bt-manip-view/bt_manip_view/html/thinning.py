"""Downsample curves and bars without losing visible peaks."""

from collections.abc import Iterable

import numpy as np

from bt_manip.record import Interval

SAMPLES = 4000
"""Samples of a plot that are kept: several per pixel of a wide screen."""

BARS = 4000
"""Bars of a timeline that are kept."""


def thin(rows: np.ndarray, samples: int = SAMPLES) -> np.ndarray:
    """Downsample lines to the samples with the smallest and largest values of equal sections.

    Peaks keep their values and times.

    Args:
        rows: Times [s], then the values of each line.  # (n, 1 + k)
        samples: Largest number of rows to return.
    """
    if len(rows) <= samples:
        return rows
    lines = max(rows.shape[1] - 1, 1)
    sections = np.array_split(np.nan_to_num(rows[:, 1:]), samples // (2 * lines))
    starts = np.cumsum([0, *map(len, sections[:-1])])
    extremes = [np.stack([one.argmin(axis=0), one.argmax(axis=0)]) for one in sections]
    return rows[np.unique([start + at for start, at in zip(starts, extremes, strict=True)])]


def merge(rows: Iterable[list[Interval]], bars: int = BARS) -> list[list[Interval]]:
    """Merge neighbouring intervals of the same status of each row until about `bars` are left."""
    kept, gap = [sorted(row) for row in rows], 0.0
    while sum(map(len, kept)) > max(bars, len(kept) * 10):
        gap = max(2.0 * gap, 0.02)
        kept = [_join(row, gap) for row in kept]
    return kept


def _join(row: list[Interval], gap: float) -> list[Interval]:
    joined: list[Interval] = []
    last: dict[str, int] = {}  # of each status, in `joined`
    for one in row:
        i = last.get(one.status)
        if i is not None and one.start - joined[i].end <= gap:
            end, reason = max(joined[i].end, one.end), joined[i].reason or one.reason
            joined[i] = joined[i]._replace(end=end, reason=reason)
        else:
            last[one.status] = len(joined)
            joined.append(one)
    return joined
