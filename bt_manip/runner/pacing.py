"""Slowing a run down to real time: the only place where a run looks at a wall clock."""

import time


class Pacing:
    """Keeps simulated time from running ahead of wall time; it never changes what is simulated."""

    def __init__(self, factor: float | None) -> None:
        """Choose the pace.

        Args:
            factor: Simulated seconds per second of wall time; None runs free.
        """
        self._factor = factor
        self._wall = self._simulated = 0.0

    def start(self, simulated: float) -> None:
        """Begin to count at this simulated time [s]."""
        self._wall, self._simulated = time.perf_counter(), simulated

    def wait(self, simulated: float) -> None:
        """Sleep until wall time has caught up with this simulated time [s]."""
        if self._factor is None:
            return
        due = self._wall + (simulated - self._simulated) / self._factor
        ahead = due - time.perf_counter()
        if ahead > 0.0:
            time.sleep(ahead)
        elif ahead < -1.0:  # it cannot keep up: do not hurry afterwards to make up for it
            self.start(simulated)
