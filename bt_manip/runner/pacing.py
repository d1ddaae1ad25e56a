"""Pacing of simulated time by wall time."""

import time


class Pacing:
    """Slows simulated time down to wall time; the simulation itself stays the same."""

    def __init__(self, factor: float | None) -> None:
        """Set the real-time factor.

        Args:
            factor: Simulated seconds per second of wall time; None runs as fast as possible.
        """
        self.factor = factor
        self._wall = self._simulated = 0.0

    def start(self, simulated: float) -> None:
        """Start at a simulated time [s]."""
        self._wall, self._simulated = time.perf_counter(), simulated

    def wait(self, simulated: float) -> None:
        """Sleep until wall time reaches a simulated time [s]."""
        if self.factor is None:
            return
        due = self._wall + (simulated - self._simulated) / self.factor
        ahead = due - time.perf_counter()
        if ahead > 0.0:
            time.sleep(ahead)
        elif ahead < -1.0:  # more than a second late: do not catch up
            self.start(simulated)
