"""Progress of a run with several cycles."""

import time


class Progress:
    """Counts how cycles ended, and estimates the wall time that is left.

    Args:
        cycles: Number of cycles; 0 is unlimited.
    """

    def __init__(self, cycles: int) -> None:
        self._cycles = cycles
        self._done = self._succeeded = self._left = 0
        self._start = time.perf_counter()

    def count(self, cycle: int, status: str) -> None:
        """Count a cycle that has ended; the first number is 0."""
        self._done += 1
        self._succeeded += status == "SUCCESS"
        self._left = self._cycles - cycle - 1

    def __str__(self) -> str:
        """Return success rate and time left; empty for a single cycle, and before one has ended."""
        if self._cycles == 1 or not self._done:
            return ""
        rate = f"{self._succeeded} of {self._done} cycles succeeded"
        if self._left <= 0:
            return rate
        each = (time.perf_counter() - self._start) / self._done
        return f"{rate}, about {_duration(self._left * each)} left"


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400.0 else f"{seconds / 3600:.1f} h"
