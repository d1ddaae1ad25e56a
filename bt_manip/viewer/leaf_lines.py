"""The leaves of a cycle that have ended, a line for each."""

from typing import Any

from rich.console import Console

from bt_manip.bt import NodeKind
from bt_manip.bt.nodes import TreeNode
from bt_manip.runner import Run
from bt_manip.viewer.wrapping import print_wrapped

ANSWERS = {"SUCCESS": "yes", "FAILURE": "no"}
"""Status of a condition as the answer to its question."""

MAX_LINES = 100
"""Number of lines that are kept of a cycle, the last ones."""

INDENT = 20
"""Column of the name [characters]."""


class LeafLines:
    """Collects time, status, name and message of each leaf that ends.

    A leaf that a reactive node checks at every tick gets a line when its status changes. Conditions
    have answers: a ``no`` is no failure of the task. Where there are several robots, a line names
    the one that it is about.

    Args:
        run: The run; its tree is observed until it ends.
    """

    def __init__(self, run: Run) -> None:
        self._cell = run.station.cell
        self._several = len(run.station.robots) > 1
        self._tick = 0
        self._ended: dict[Any, tuple[int, str]] = {}  # tick and status of each leaf's last end
        self.begin()
        run.tree.observers.append(self._node_changed)

    def begin(self) -> None:
        """Begin a cycle."""
        self._start, self._lines, self._dropped = self._cell.time, list[str](), 0

    def end_tick(self) -> None:
        """Count a tick."""
        self._tick += 1

    def print(self, console: Console) -> None:
        """Print the lines since the last call, the last `MAX_LINES` of them, and forget them."""
        lines, dropped = self._lines, self._dropped
        self._lines, self._dropped = [], 0
        more = [f"{dropped} earlier lines are not shown"] if dropped else []
        if lines:
            print_wrapped(console, *more, *lines, indent=INDENT)

    def _node_changed(self, node: TreeNode, old: Any, new: Any) -> None:
        if node.children or new.name not in ANSWERS:
            return
        before, self._ended[node] = self._ended.get(node), (self._tick, new.name)
        if before == (self._tick - 1, new.name):
            return
        # Printed later: an exception raised here would count as one of the tree.
        status = ANSWERS[new.name] if node.kind is NodeKind.CONDITION else new.name
        robot = getattr(node, "robot_name", "") if self._several else ""
        message = f": {node.feedback_message}" if node.feedback_message else ""
        name = f"{robot}: {node.name}" if robot else node.name
        time = self._cell.time - self._start
        self._lines.append(f"{time:7.2f} s  {status:7}  {name}{message}")
        if len(self._lines) > MAX_LINES:
            del self._lines[0]
            self._dropped += 1
