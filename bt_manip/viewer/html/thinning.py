"""Fewer samples and intervals for a page, so that nothing which shows is lost."""

from collections.abc import Iterable

import numpy as np

from bt_manip.record import Interval

LINE_SAMPLES = 4000
"""Number of samples of a line that are kept: several for each pixel of a wide screen."""

BARS = 4000
"""Number of bars of a time line that are kept."""


def thin(t: np.ndarray, values: np.ndarray, samples: int = LINE_SAMPLES) -> tuple[np.ndarray, ...]:
    """Return at most this many samples of a line: the smallest and the largest of each section.

    Peaks therefore keep their values and their times.

    Args:
        t: Times [s].  # (n,)
        values: Values at these times.  # (n,)
        samples: Number of samples that are kept.
    """
    if len(t) <= samples:
        return t, values
    sections = np.array_split(np.arange(len(t)), samples // 2)
    kept = [part[[values[part].argmin(), values[part].argmax()]] for part in sections]
    indices = np.unique(kept)
    return t[indices], values[indices]


def merge(rows: Iterable[list[Interval]], bars: int = BARS) -> tuple[list[list[Interval]], float]:
    """Join intervals of the same status that are close together until there are few enough.

    Args:
        rows: Intervals of each row, by their starts.
        bars: Number of intervals that are kept in all rows together.

    Returns:
        The intervals of each row, and the largest gap that was closed [s].
    """
    kept, gap = [sorted(row) for row in rows], 0.0
    while sum(map(len, kept)) > max(bars, len(kept) * 10):
        gap = max(2.0 * gap, 0.02)
        kept = [_join(row, gap) for row in kept]
    return kept, gap


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
