"""Plain view of a run for output that is not a terminal: a line per event."""

from rich.console import Console

from bt_manip.runner import Run, RunObserver
from bt_manip.viewer.leaf_lines import LeafLines
from bt_manip.viewer.progress import Progress
from bt_manip.viewer.wrapping import print_wrapped


class PlainView(RunObserver):
    """Prints a line for each cycle, and one for each leaf in a run of one cycle or one that fails.

    A number of 0 cycles is unlimited.
    """

    def __init__(self, console: Console, *, cycles: int) -> None:
        self._console = console
        self._cycles = cycles
        self._cycle = 0

    def run_started(self, run: Run) -> None:
        """Observe the leaves of the tree."""
        self._cell = run.station.cell
        self._start = self._cell.time
        self._progress = Progress(self._cycles)
        self._leaves = LeafLines(run)

    def cycle_started(self, cycle: int) -> None:
        """Store the number and the start time of the cycle."""
        self._cycle = cycle
        self._start = self._cell.time
        self._leaves.begin()

    def after_tick(self) -> None:
        """Print the leaves that have ended."""
        self._leaves.end_tick()
        if self._cycles == 1:
            self._leaves.print(self._console)

    def cycle_ended(self, status: str, reason: str) -> None:
        """Print status and duration of the cycle, and the progress of the run."""
        self._progress.count(self._cycle, status)
        if status != "SUCCESS":
            self._leaves.print(self._console)
        total = f"/{self._cycles}" if self._cycle < self._cycles else ""  # not of --episode
        elapsed = self._cell.time - self._start
        line = f"cycle {self._cycle + 1}{total}: {status} after {elapsed:.2f} s"
        if progress := str(self._progress):
            line += f" ({progress})"
        print_wrapped(self._console, f"{line}: {reason}" if reason else line)
