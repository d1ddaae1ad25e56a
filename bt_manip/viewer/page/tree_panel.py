"""The tree as it runs, with statuses and reasons."""

from html import escape
from typing import Any

from bt_manip.runner import RunEvent
from bt_manip.viewer.tree_text import MARKS

from .panel import Panel

COLOURS = {
    "IDLE": "#868e96",
    "RUNNING": "#e67700",
    "SUCCESS": "#2b8a3e",
    "FAILURE": "#c92a2a",
    "SKIPPED": "#868e96",
}
"""Colour of each status."""

FOLDED_ABOVE = 40
"""Number of nodes above which sub-trees that neither run nor have failed can be folded."""

NO_NODE = "none"
"""Choice of no node."""


class TreePanel(Panel):
    """Shows the tree as HTML, which is sent whole, and only when it has changed."""

    in_tab = False

    def __init__(self, page: Any) -> None:
        """Add its inputs to the current container.

        Args:
            page: The page.
        """
        self._nodes: dict[int, dict[str, Any]] = {}  # by uid, in the order of the tree
        self._depths: dict[int, int] = {}
        self._paths: dict[str, int] = {}
        self._statuses: dict[int, str] = {}  # last status in this cycle
        self._reasons: dict[int, str] = {}
        self._lines: dict[int, str] = {}  # HTML of each node, until it changes
        self._changed = False
        gui, self._controls = page.server.gui, page.controls
        self._search = gui.add_text("Search", "", hint="Part of a node's name or kind")
        self._search.on_update(self._redraw)
        self._fold = gui.add_checkbox(
            "Fold", True, hint="Fold sub-trees of a large tree that neither run nor have failed"
        )
        self._fold.on_update(self._redraw)
        self._choice = gui.add_dropdown(
            "Breakpoint", (NO_NODE,), hint="Pause after the tick in which this node starts"
        )
        self._choice.on_update(self._set_breakpoint)
        self._html = gui.add_html("")

    def reset(self) -> None:
        """Forget the statuses; the tree follows as an event."""
        self._statuses.clear()
        self._reasons.clear()
        self._lines.clear()
        self._changed = True

    def handle(self, event: RunEvent) -> None:
        """Keep statuses and reasons."""
        data = event.data
        if event.kind == "tree":
            self._replace(data["nodes"])
        elif event.kind == "cycle" and data["status"] == "RUNNING":
            self.reset()
        elif event.kind == "status":
            # A parent resets its children as soon as it ends: their last status is kept.
            if data["status"] == "IDLE" and data["old"] != "RUNNING":
                return
            self._statuses[data["uid"]] = data["status"]
            self._reasons[data["uid"]] = data["reason"]
            self._lines.pop(data["uid"], None)
        else:
            return
        self._changed = True

    def draw(self) -> None:
        """Send the tree if it has changed."""
        if not self._changed:
            return
        self._changed = False
        self._html.content = self.html()

    def html(self) -> str:
        """Return the nodes that are shown, a line for each."""
        shown = self._found() if self._search.value.strip() else self._open()
        lines = [self._lines.get(uid) or self._line(uid) for uid in shown]
        return (
            f'<div style="font-size:0.85em;line-height:1.5;padding:0 0.8em">{"".join(lines)}</div>'
        )

    # Internal

    def _replace(self, nodes: list[dict[str, Any]]) -> None:
        children: dict[int, list[int]] = {}
        by_uid = {node["uid"]: node for node in nodes}
        for node in nodes:
            parent = node["parent"] if node["parent"] in by_uid else 0
            children.setdefault(parent, []).append(node["uid"])
        self._nodes, self._depths = {}, {}
        stack = [(uid, 0) for uid in reversed(children.get(0, []))]
        while stack:
            uid, depth = stack.pop()
            self._nodes[uid], self._depths[uid] = by_uid[uid], depth
            stack.extend((child, depth + 1) for child in reversed(children.get(uid, [])))
        self._lines.clear()
        self._statuses.clear()
        self._reasons.clear()
        self._paths = {node["path"]: node["uid"] for node in self._nodes.values()}
        self._choice.options = (NO_NODE, *self._paths)

    def _redraw(self, _: Any) -> None:
        self._changed = True

    def _set_breakpoint(self, _: Any) -> None:
        path = self._choice.value
        self._controls.breakpoints = frozenset() if path == NO_NODE else frozenset([path])
        self._lines = {}
        self._changed = True

    def _found(self) -> list[int]:
        """Return the nodes with the searched text, and their ancestors."""
        wanted = self._search.value.strip().lower()
        shown = set()
        for uid, node in self._nodes.items():
            if wanted in f"{node['name']} {node['registration']}".lower():
                while uid and uid not in shown:
                    shown.add(uid)
                    uid = self._parent(uid)
        return [uid for uid in self._nodes if uid in shown]

    def _open(self) -> list[int]:
        """Return the nodes that are not in a folded sub-tree."""
        if not self._fold.value or len(self._nodes) <= FOLDED_ABOVE:
            return list(self._nodes)
        opened = {0}
        for uid in [u for u, s in self._statuses.items() if s in ("RUNNING", "FAILURE")]:
            while uid and uid not in opened:
                opened.add(uid)
                uid = self._parent(uid)
        return [uid for uid in self._nodes if self._parent(uid) in opened]

    def _parent(self, uid: int) -> int:
        node = self._nodes.get(uid)
        return node["parent"] if node is not None and node["parent"] in self._nodes else 0

    def _line(self, uid: int) -> str:
        node = self._nodes[uid]
        status = self._statuses.get(uid, "IDLE")
        name, kind = escape(node["name"]), escape(node["registration"])
        mark, _ = MARKS.get(status, ("?", ""))
        weight = "bold" if status == "RUNNING" else "normal"
        parts = [f'<b>{mark}</b> <span style="font-weight:{weight}">{name}</span>']
        if kind != name:
            parts.append(f'<span style="opacity:0.6">{kind}</span>')
        if node["path"] in self._controls.breakpoints:
            parts.insert(0, '<span title="breakpoint">●</span>')
        if reason := self._reasons.get(uid):
            parts.append(f"<i>{escape(reason)}</i>")
        style = f"padding-left:{self._depths[uid]}em;color:{COLOURS.get(status, '#000')}"
        self._lines[uid] = line = f'<div style="{style}">{" ".join(parts)}</div>'
        return line
