"""Plain view of a run for output that is not a terminal: a line per event."""

from typing import Any

from rich.console import Console

from bt_manip.bt.nodes import TreeNode
from bt_manip.runner import Run, RunObserver
from bt_manip.viewer.progress import Progress
from bt_manip.viewer.wrapping import print_wrapped


class PlainView(RunObserver):
    """Prints a line for each cycle and, in a run of one cycle, for each leaf that ends.

    A leaf that a reactive node checks at every tick gets a line when its status changes.

    Args:
        console: Console to print to.
        cycles: Number of cycles; 0: unlimited.
    """

    def __init__(self, console: Console, *, cycles: int) -> None:
        self._console = console
        self._cycles = cycles
        self._cycle = 0
        self._lines: list[str] = []  # of leaves that have ended in this tick
        self._tick = 0
        self._ended: dict[Any, tuple[int, str]] = {}  # tick and status of each leaf's last end

    def run_started(self, run: Run) -> None:
        """Observe the leaves of the tree in a run of one cycle."""
        self._cell = run.station.cell
        self._start = self._cell.time
        self._progress = Progress(self._cycles)
        if self._cycles == 1:
            run.tree.observers.append(self._node_changed)

    def cycle_started(self, cycle: int) -> None:
        """Store the number and the start time of the cycle."""
        self._cycle = cycle
        self._start = self._cell.time

    def after_tick(self) -> None:
        """Print the leaves that have ended."""
        self._tick += 1
        lines, self._lines = self._lines, []
        for line in lines:
            print_wrapped(self._console, line, indent=20)

    def cycle_ended(self, status: str, reason: str) -> None:
        """Print status and duration of the cycle, and the progress of the run."""
        self._progress.count(self._cycle, status)
        total = f"/{self._cycles}" if self._cycles else ""
        line = f"cycle {self._cycle + 1}{total}: {status} after {self._elapsed:.2f} s"
        if progress := str(self._progress):
            line += f" ({progress})"
        print_wrapped(self._console, f"{line}: {reason}" if reason else line)

    @property
    def _elapsed(self) -> float:
        return float(self._cell.time - self._start)

    def _node_changed(self, node: TreeNode, old: Any, new: Any) -> None:
        if node.children or new.name not in ("SUCCESS", "FAILURE"):
            return
        before, self._ended[node] = self._ended.get(node), (self._tick, new.name)
        if before == (self._tick - 1, new.name):
            return
        message = f": {node.feedback_message}" if node.feedback_message else ""
        # Printed later: an exception raised here would count as one of the tree.
        self._lines.append(f"{self._elapsed:7.2f} s  {new.name:7}  {node.name}{message}")
