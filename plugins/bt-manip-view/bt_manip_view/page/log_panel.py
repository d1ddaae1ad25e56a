"""The log of a run, and its blackboard."""

from typing import Any

from bt_manip.runner import RunEvent
from bt_manip_recording import log_line

from .panel import Panel

LINES = 2000
"""Largest number of lines of the log."""

SHOWN_CHARACTERS = 200
"""Largest number of characters of a value."""

REPEATED = 0.05
"""Simulated time after which a leaf may repeat a line [s]."""


class LogPanel(Panel):
    """Logs results and messages of leaves, failures, cycles, and added and removed objects.

    A line consists of time, kind, text and uid of the node, 0 without a node. Each browser filters
    by kind; ``condition`` is hidden by default.
    """

    def __init__(self, page: Any) -> None:
        self._log = page.gui.add("log", lines=[])
        self._new: list[list[Any]] = []
        self._nodes: dict[int, Any] = {}
        self._parents: set[int] = set()
        self._texts: dict[int, str] = {}  # messages by uid
        self._succeeded: tuple[int, float] | None = None  # last leaf, until its message arrives
        self._said: dict[int, tuple[float, str]] = {}  # time and text of the last line of a leaf

    def reset(self) -> None:
        """Clear the lines."""
        for kept in (self._new, self._texts, self._said):
            kept.clear()
        self._succeeded = None
        self._log.lines = []

    def handle(self, event: RunEvent) -> None:
        """Add a line."""
        data = event.data
        if event.kind == "message":
            self._texts[data["uid"]] = data["text"]
        self._say_succeeded()
        if event.kind == "tree":
            self._nodes = {node["uid"]: node for node in data["nodes"]}
            self._parents = {node["parent"] for node in data["nodes"]}
        elif event.kind == "status":
            self._note_status(event)
        elif (line := log_line(event)) is not None:
            level, text = line
            kind = "cycle" if level == "INFO" and event.kind == "cycle" else level.lower()
            self._new.append([event.time, kind, text, 0])

    def draw(self) -> None:
        """Send the new lines."""
        self._say_succeeded()
        if self._new:
            self._log.append("lines", self._new, LINES)
            self._new = []

    # Internal

    def _note_status(self, event: RunEvent) -> None:
        uid, status = event.data["uid"], event.data["status"]
        if status == "SUCCESS" and uid not in self._parents:
            self._succeeded = uid, event.time
        elif status == "FAILURE" and event.data["reason"]:
            self._say(event.time, uid, "failure", event.data["reason"])

    def _say_succeeded(self) -> None:
        if self._succeeded is not None:
            (uid, time), self._succeeded = self._succeeded, None
            self._say(time, uid, "success", self._texts.get(uid, ""))

    def _say(self, time: float, uid: int, kind: str, text: str) -> None:
        """Add a line of a node, unless a reactive node has just caused the same line."""
        before, self._said[uid] = self._said.get(uid), (time, text)
        if before is not None and before[0] > time - REPEATED and before[1] == text:
            return
        node = self._nodes.get(uid, {"kind": "", "name": str(uid)})
        if node["kind"] == "Condition":  # a "no" is an answer, no failure of the task
            text = f"{'yes' if kind == 'success' else 'no'}{', ' if text else ''}{text}"
            kind = "condition"
        self._new.append([time, kind, f"{node['name']}: {text or 'succeeded'}", uid])


class BlackboardPanel(Panel):
    """Shows the entries of the blackboard, sorted by key."""

    def __init__(self, page: Any) -> None:
        self._board = page.gui.add("blackboard", values={})
        self._changed: dict[str, str | None] = {}

    def reset(self) -> None:
        """Clear the entries."""
        self._changed.clear()
        self._board.values = {}

    def handle(self, event: RunEvent) -> None:
        """Store the value."""
        if event.kind == "blackboard":
            value, text = event.data["value"], str(event.data["value"])
            if len(text) > SHOWN_CHARACTERS:
                text = f"{text[:SHOWN_CHARACTERS]}…"
            self._changed[event.data["key"]] = None if value is None else text

    def draw(self) -> None:
        """Send the changed entries."""
        if self._changed:
            self._board.merge("values", self._changed)
            self._changed = {}
