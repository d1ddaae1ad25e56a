"""Timeline below the scene: running leaf, failures, cycles and breakpoints."""

from typing import Any

from bt_manip.runner import RunEvent

from .gui import GuiEvent, is_number
from .panel import Panel

KEPT_CHANGES = 4000
"""Largest number of changes of the running leaf, and of marks."""


class TimelinePanel(Panel):
    """Shows which leaf of each robot ran when; a click shows that time on the page."""

    place = "below"
    whole_run = True

    def __init__(self, page: Any) -> None:
        self._page, self._controls = page, page.controls
        self._line = page.gui.add(
            "timeline", leaves=[], marks=[], robots=[], time=0.0, start=0.0, end=None, shown=None
        )
        self._line.on("seek", self._seek, lambda value: value is None or is_number(value))
        self._nodes: dict[int, Any] = {}
        self._parents: set[int] = set()
        self._running: dict[int, str] = {}  # robots of the running leaves, the latest last
        self._robots: list[str] = []
        self._new: dict[str, list[Any]] = {"leaves": [], "marks": []}

    def reset(self) -> None:
        """Clear the past."""
        self._running.clear()
        self._robots = []
        self._new = {"leaves": [], "marks": []}
        self._line.leaves, self._line.marks, self._line.robots = [], [], []

    def handle(self, event: RunEvent) -> None:
        """Store the running leaf and marks."""
        data = event.data
        if event.kind == "tree":
            self._nodes = {node["uid"]: node for node in data["nodes"]}
            self._parents = {node["parent"] for node in data["nodes"]}
            for robot in set(self._running.values()):
                self._new["leaves"].append([event.time, 0, "", robot])
            self._running.clear()
        elif event.kind == "status":
            self._note_status(event)
        elif event.kind == "controller" and data["robot"] not in self._robots:
            self._robots.append(data["robot"])
        elif event.kind == "cycle":
            failed = data["status"] == "FAILURE"
            if failed or data["status"] == "RUNNING":
                text = f"cycle {data['cycle'] + 1}"
                text += f" failed: {data['reason']}" if failed else ""
                self._mark(event.time, "failure" if failed else "cycle", text)

    def draw(self) -> None:
        """Send new leaves and marks, and the time."""
        for name, values in self._new.items():
            if values:
                self._line.append(name, values, KEPT_CHANGES)
        self._new = {"leaves": [], "marks": []}
        self._line.robots, (self._line.start, self._line.end) = [*self._robots], self._page.span
        self._line.time = round(self._controls.time, 6)
        self._line.shown = self._page.shown_time

    # Internal

    def _note_status(self, event: RunEvent) -> None:
        uid, status, path = (event.data[key] for key in ("uid", "status", "path"))
        if status == "FAILURE" and uid not in self._parents:
            if self._nodes.get(uid, {}).get("kind") != "Condition":
                self._mark(event.time, "failure", f"{path}: {event.data['reason']}")
        if status != "IDLE" and event.data["old"] != "RUNNING":
            if path in self._controls.breakpoints:
                self._mark(event.time, "breakpoint", path)
        if uid in self._parents:
            return
        robot = self._running.get(uid, event.data.get("robot", ""))
        before = self._latest(robot)
        self._running.pop(uid, None)
        if status == "RUNNING":
            self._running[uid] = robot
        if (now := self._latest(robot)) != before:
            name = self._nodes[now]["name"] if now in self._nodes else ""
            self._new["leaves"].append([event.time, now, name, robot])

    def _latest(self, robot: str) -> int:
        """Return the latest running leaf of a robot; 0 without one."""
        return next((uid for uid, of in reversed(self._running.items()) if of == robot), 0)

    def _mark(self, time: float, kind: str, text: str) -> None:
        self._new["marks"].append([time, kind, text])

    def _seek(self, event: GuiEvent) -> None:
        self._page.show_time(event.value)
