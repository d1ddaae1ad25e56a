"""Downsample curves and bars without losing visible peaks."""

from collections.abc import Iterable

import numpy as np

from bt_manip.record import Interval

LINE_SAMPLES = 4000
"""Samples of a line that are kept: several per pixel of a wide screen."""

BARS = 4000
"""Bars of a timeline that are kept."""


def thin(t: np.ndarray, values: np.ndarray, samples: int = LINE_SAMPLES) -> tuple[np.ndarray, ...]:
    """Downsample a line to the smallest and the largest sample of equal sections.

    Peaks keep their values and times.

    Args:
        t: Times [s].  # (n,)
        values: Values at these times.  # (n,)
        samples: Largest number of samples to return.
    """
    if len(t) <= samples:
        return t, values
    sections = np.array_split(np.arange(len(t)), samples // 2)
    kept = [part[[values[part].argmin(), values[part].argmax()]] for part in sections]
    indices = np.unique(kept)
    return t[indices], values[indices]


def merge(rows: Iterable[list[Interval]], bars: int = BARS) -> tuple[list[list[Interval]], float]:
    """Merge neighbouring intervals of the same status until at most `bars` are left.

    Args:
        rows: Intervals of each row.
        bars: Number of intervals to keep in all rows together.

    Returns:
        The intervals of each row, and the largest gap between merged intervals [s].
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
