"""The live view of a run in a terminal."""

import time
from collections.abc import Iterator, Mapping
from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from bt_manip.bt import NodeKind, NodeStatus
from bt_manip.bt.nodes import TreeNode
from bt_manip.runner import Run, RunObserver
from bt_manip.viewer.leaf_lines import LeafLines
from bt_manip.viewer.progress import Progress
from bt_manip.viewer.wrapping import print_wrapped

REDRAW = 0.125
"""Wall time between two redraws [s]; each takes some milliseconds."""

MARKS = {
    "IDLE": ("·", "dim"),
    "RUNNING": ("▶", "bold yellow"),
    "SUCCESS": ("✓", "green"),
    "FAILURE": ("✗", "bold red"),
    "SKIPPED": ("-", "dim"),
    "NO": ("○", "dim"),
}
"""Mark and style of each status, and of a condition that answers no."""

PLAIN_MARKS = {"▶": ">", "✓": "+", "✗": "x", "·": ".", "○": "o"}
"""Marks for ASCII terminals."""


class TerminalView(RunObserver):
    """Shows the tree with statuses and reasons, the cycle, the leaf and the real-time factor.

    After a cycle that failed, and at the end of a run of one cycle, a line for each leaf stays. A
    run of several cycles also shows the success rate and the remaining wall time. Redraws happen
    between ticks, in the thread of the run, at most every `REDRAW` seconds; they cost a few percent
    of the wall time. A number of 0 cycles is unlimited.
    """

    def __init__(self, console: Console, *, cycles: int) -> None:
        self._console = console
        self._cycles = cycles
        self._statuses: dict[Any, str] = {}  # last status of each node in this cycle
        self._live: Live | None = None
        self._ascii = not str(console.encoding).lower().startswith("utf")

    def run_started(self, run: Run) -> None:
        """Start drawing, and observe the nodes of the tree."""
        self._run = run
        run.tree.observers.append(self._node_changed)
        self._leaves = LeafLines(run)
        self._cycle = 0
        self._progress = Progress(self._cycles)
        self._wall_start = time.perf_counter()
        self._next = 0.0
        self._time_start = run.station.cell.time
        self._live = Live(
            console=self._console, auto_refresh=False, transient=True, vertical_overflow="crop"
        )
        self._live.start()

    def cycle_started(self, cycle: int) -> None:
        """Clear the statuses of the last cycle."""
        self._cycle = cycle
        self._statuses.clear()
        self._leaves.begin()

    def after_tick(self) -> None:
        """Redraw if `REDRAW` has passed."""
        self._leaves.end_tick()
        now = time.perf_counter()
        if self._live is not None and now >= self._next:
            self._live.update(self._picture(now), refresh=True)
            self._next = time.perf_counter() + REDRAW

    def cycle_ended(self, status: str, reason: str) -> None:
        """Count the cycle; print its leaves and the reason of a failure above the live view."""
        self._progress.count(self._cycle, status)
        failed = status != "SUCCESS"
        if failed or self._cycles == 1:
            self._leaves.print(self._console)
        self._leaves.begin()
        if failed and self._live is not None:
            line = f"cycle {self._cycle + 1} failed: {reason}"
            print_wrapped(self._console, line, style="red")

    def run_ended(self) -> None:
        """Print the leaves of a cycle that did not end, and restore the terminal."""
        live, self._live = self._live, None
        self._leaves.print(self._console)
        if live is not None:
            live.stop()

    def _node_changed(self, node: TreeNode, old: Any, new: Any) -> None:
        """Keep the final status of a node: a parent resets its children as soon as it ends."""
        behaviour = getattr(node, "behaviour", node)  # of a wrapped stock behaviour
        if new.name != "IDLE" or old.name == "RUNNING":
            self._statuses[behaviour] = new.name

    def _picture(self, now: float) -> Group:
        run = self._run
        lines = list(tree_lines(run.tree.root, self._statuses, ascii_only=self._ascii))
        head = [self._headline(now)]
        if progress := str(self._progress):
            head.append(Text(progress, style="cyan", no_wrap=True, overflow="ellipsis"))
        room = max(3, self._console.size.height - 2 - len(head))
        if len(lines) > room:
            lines = _around_running(lines, room)
        return Group(*head, *lines)

    def _headline(self, now: float) -> Text:
        run = self._run
        simulated = run.station.cell.time - self._time_start
        factor = simulated / max(now - self._wall_start, 1e-9)
        total = f"/{self._cycles}" if self._cycle < self._cycles else ""  # not of --episode
        running = NodeStatus.RUNNING
        leaves = [n.name for n in run.tree if not n.children and n.engine_status is running]
        name = run.request.tree.name.rpartition("/")[2]
        line = Text(name, style="bold", no_wrap=True, overflow="ellipsis")
        line.append(f"  cycle {self._cycle + 1}{total}", style="not bold")
        line.append(f"  {leaves[-1] if leaves else '-'}", style="not bold yellow")
        line.append(f"  {simulated:.2f} s  {factor:.1f} x real time", style="not bold")
        return line


def tree_lines(
    root: Any, statuses: Mapping[Any, str], *, ascii_only: bool = False
) -> Iterator[Text]:
    """Yield a line for each node, children below their parents, with the mark of its status."""
    # A stack instead of recursion: a tree may be deeper than Python's stack.
    stack = [(root, 0)]
    while stack:
        node, depth = stack.pop()
        status = statuses.get(node, "IDLE")
        if status == "FAILURE" and getattr(node, "kind", None) is NodeKind.CONDITION:
            status = "NO"
        mark, style = MARKS.get(status, ("?", "dim"))
        if ascii_only:
            mark = PLAIN_MARKS.get(mark, mark)
        line = Text("  " * depth, no_wrap=True, overflow="ellipsis")
        line.append(f"{mark} ", style=style)
        line.append(str(node.name), style=style if status != "SUCCESS" else "")
        kind = getattr(node, "registration", type(node).__name__)
        if kind != node.name:
            line.append(f" {kind}", style="dim")
        message = getattr(node, "feedback_message", "")
        if message and status != "IDLE":
            line.append(f"  {message}", style="dim")
        yield line
        stack.extend((child, depth + 1) for child in reversed(node.children))


def _around_running(lines: list[Text], room: int) -> list[Text]:
    """Return the line of the root and the lines around the last running node."""
    running = [i for i, line in enumerate(lines) if line.plain.lstrip()[:1] in ("▶", ">")]
    middle = running[-1] if running else 0
    first = min(max(1, middle - room // 2), len(lines) - room + 1)
    return [lines[0], *lines[first : first + room - 1]]
