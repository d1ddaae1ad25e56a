"""Progress of a run with several cycles."""

import time


class Progress:
    """Counts successful cycles and estimates the remaining wall time.

    Args:
        cycles: Number of cycles; 0: unlimited.
    """

    def __init__(self, cycles: int) -> None:
        self._cycles = cycles
        self._done = self._succeeded = self._left = 0
        self._start = time.perf_counter()

    def count(self, cycle: int, status: str) -> None:
        """Count a cycle that has ended, numbered from 0."""
        self._done += 1
        self._succeeded += status == "SUCCESS"
        self._left = self._cycles - cycle - 1

    def __str__(self) -> str:
        """Return success rate and remaining time; empty for one cycle or before the first end."""
        if self._cycles == 1 or not self._done:
            return ""
        rate = f"{self._succeeded} of {self._done} cycles succeeded"
        if self._left <= 0:
            return rate
        each = (time.perf_counter() - self._start) / self._done
        return f"{rate}, about {duration_text(self._left * each)} left"


def duration_text(seconds: float) -> str:
    """Return a duration with the unit that fits."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400.0 else f"{seconds / 3600:.1f} h"
