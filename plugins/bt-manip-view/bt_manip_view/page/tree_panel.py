"""The running tree: states of its nodes, breakpoints, findings of its check."""

from typing import Any

from bt_manip.runner import RunEvent

from .gui import GuiEvent
from .panel import Panel


class TreePanel(Panel):
    """Shows the tree, and the states of its nodes; only changes are sent.

    Selection, folding and search are separate in each browser.
    """

    place = "left"

    def __init__(self, page: Any) -> None:
        self._page, self._controls = page, page.controls
        self._tree = page.gui.add(
            "tree", nodes=[], states={}, breakpoints=[], problems=[], findings={}, edited=False,
            failed=False,
        )  # fmt: skip
        self._tree.on("breakpoint", self._toggle, self._is_path)
        self._paths: frozenset[str] = frozenset()
        self._texts: dict[int, str] = {}  # messages by uid
        self._states: dict[str, list[Any]] = {}  # by uid: status, message, start, end [s]
        self._changed: dict[str, list[Any]] = {}

    def reset(self) -> None:
        """Clear states and errors; an event with the tree follows."""
        self._texts.clear()
        self._forget_states()
        self._tree.problems = []

    def handle(self, event: RunEvent) -> None:
        """Store nodes, states and errors."""
        data = event.data
        if event.kind == "status":
            self._keep_status(event)
        elif event.kind == "message":
            uid = data["uid"]
            self._texts[uid] = data["text"]
            if (state := self._states.get(str(uid))) is not None:
                self._keep(uid, [state[0], data["text"], *state[2:]])
        elif event.kind == "tree":
            self._tree.nodes = data["nodes"]
            self._paths = frozenset(node["path"] for node in data["nodes"])
            self._texts.clear()
            self._forget_states()
        elif event.kind == "cycle":
            if data["status"] == "RUNNING":
                self._forget_states()
            self._tree.failed = data["status"] == "FAILURE"
        elif event.kind == "edit":
            self._tree.problems = data["problems"]

    def draw(self) -> None:
        """Send the changes."""
        if self._changed:
            self._tree.merge("states", self._changed)
            self._changed = {}
        self._tree.breakpoints = sorted(self._controls.breakpoints)
        self._tree.findings = self._page.findings
        self._tree.edited = self._controls.edited

    # Internal

    def _keep_status(self, event: RunEvent) -> None:
        data = event.data
        uid, status, before = data["uid"], data["status"], self._states.get(str(data["uid"]))
        # A parent resets its children as soon as it ends: keep their last status.
        if status == "IDLE" and data["old"] != "RUNNING":
            return
        start, end = event.time, None if status == "RUNNING" else event.time
        if before is not None and before[0] == "RUNNING":
            start = before[2]
        self._keep(uid, [status, data["reason"] or self._texts.get(uid, ""), start, end])

    def _keep(self, uid: int, state: list[Any]) -> None:
        self._states[str(uid)] = self._changed[str(uid)] = state

    def _forget_states(self) -> None:
        self._states.clear()
        self._changed.clear()
        self._tree.states = {}

    def _is_path(self, value: Any) -> bool:
        return isinstance(value, str) and value in self._paths | self._controls.breakpoints

    def _toggle(self, event: GuiEvent) -> None:
        self._controls.breakpoints ^= {event.value}


class NodePanel(Panel):
    """Shows the node selected in the browser: kind, status, ports and their values."""

    def __init__(self, page: Any) -> None:
        page.gui.add("node")
