"""A tree with its statuses as HTML: sub-trees are folded, running nodes are followed."""

from html import escape
from typing import Any

from bt_manip.bt import STATUS_COLOURS
from bt_manip.runner import RunEvent
from bt_manip.viewer.tree_text import MARKS

from .panel import block

OTHER_COLOUR = "#868e96"
"""Colour of nodes that are idle or were skipped; others have `STATUS_COLOURS`."""

FOLDED_ABOVE = 40
"""Number of nodes above which sub-trees that neither run nor have failed are folded."""

SHOWN_NODES = 100
"""Largest number of lines that are sent: more take the browser too long ten times a second."""

LINES_ABOVE = 8
"""Number of lines above what runs: more of them would hide it, for HTML cannot be scrolled."""


class TreeView:
    """Keeps nodes, statuses and reasons from the events of a run, and writes them as HTML.

    Attributes:
        nodes: The nodes by uid, in the order of the tree, as in the event ``tree``.
        statuses: Last status of each node in this cycle, by uid.
        reasons: Reasons of failures, by uid.
        folds: Whether a sub-tree is folded, by path, where the user has chosen it.
        follow: Whether other sub-trees of large trees are open exactly where nodes run or have
            failed, and what runs is shown first.
        chosen: Path of the chosen node.
        search: Text in name or kind of the nodes that are shown; empty for all.
        breakpoints: Paths of the nodes with breakpoints.
    """

    def __init__(self) -> None:
        """Start without a tree."""
        self.nodes: dict[int, dict[str, Any]] = {}
        self.statuses: dict[int, str] = {}
        self.reasons: dict[int, str] = {}
        self.folds: dict[str, bool] = {}
        self.follow = True
        self.chosen = self.search = ""
        self.breakpoints: frozenset[str] = frozenset()
        self._depths: dict[int, int] = {}
        self._children: dict[int, list[int]] = {}  # of 0: the root
        self._active: dict[int, None] = {}  # running and failed nodes, the latest one last
        self._followed: set[int] = set()  # these and their ancestors
        self._lines: dict[int, str] = {}  # HTML by uid, negative while folded

    def reset(self) -> None:
        """Forget statuses and reasons."""
        for kept in (self.statuses, self.reasons, self._active, self._lines):
            kept.clear()

    def handle(self, event: RunEvent) -> bool:
        """Take an event; return whether the tree looks different."""
        data = event.data
        if event.kind == "tree":
            self._replace(data["nodes"])
        elif event.kind == "cycle" and data["status"] == "RUNNING":
            self.reset()
        elif event.kind == "status":
            uid, status = data["uid"], data["status"]
            # A parent resets its children as soon as it ends: their last status is kept.
            if status == "IDLE" and data["old"] != "RUNNING":
                return False
            self.statuses[uid], self.reasons[uid] = status, data["reason"]
            self._active.pop(uid, None)
            if status in ("RUNNING", "FAILURE"):
                self._active[uid] = None
            self._forget(uid)
        else:
            return False
        return True

    def find(self, path: str) -> dict[str, Any] | None:
        """Return the node of a path."""
        return next((node for node in self.nodes.values() if node["path"] == path), None)

    def latest(self, status: str) -> str:
        """Return the path of the leaf that came last to RUNNING or FAILURE; empty if there is none.

        Args:
            status: The status that it has now.
        """
        found = [uid for uid in self._active if self.statuses[uid] == status]
        leaves = [uid for uid in found if uid not in self._children]
        return self.nodes[(leaves or found)[-1]]["path"] if found else ""

    def is_open(self, uid: int) -> bool:
        """Return whether the children of a node are shown."""
        folded = self.folds.get(self.nodes[uid]["path"])
        if folded is None:
            overcome = self.statuses.get(uid) == "SUCCESS"  # a failure inside
            return len(self.nodes) <= FOLDED_ABOVE or (uid in self._followed and not overcome)
        return not folded

    def forget_lines(self) -> None:
        """Write all lines anew: the chosen node or the breakpoints have changed."""
        self._lines.clear()

    def html(self) -> str:
        """Return the nodes that are shown, a line for each."""
        shown = self._found() if self.search else self._opened()
        first = self._first(shown)
        part = shown[first : first + SHOWN_NODES]
        above = self._with_ancestors(map(abs, part[:1]))
        kept = [uid for uid in shown[:first] if uid in above]
        lines = [self._lines.get(key) or self._line(key) for key in kept + part]
        if first > len(kept):
            lines.insert(len(kept), f"<div>⋮ {first - len(kept)} lines</div>")
        if below := len(shown) - first - len(part):
            lines.append(f"<div>⋮ {below} lines</div>")
        return block("".join(lines), "line-height:1.5")

    # Internal

    def _forget(self, uid: int) -> None:
        for key in (uid, -uid):
            self._lines.pop(key, None)

    def _replace(self, nodes: list[dict[str, Any]]) -> None:
        by_uid = {node["uid"]: node for node in nodes}
        self._children = {}
        for node in nodes:
            parent = node["parent"] if node["parent"] in by_uid else 0
            self._children.setdefault(parent, []).append(node["uid"])
        self.nodes, self._depths = {}, {0: -1}
        stack = list(reversed(self._children.get(0, [])))
        while stack:
            uid = stack.pop()
            self.nodes[uid] = by_uid[uid]
            self._depths[uid] = self._depths[self._parent(uid)] + 1
            stack.extend(reversed(self._children.get(uid, [])))
        self._followed = set()
        self.reset()

    def _parent(self, uid: int) -> int:
        parent = int(self.nodes[uid]["parent"])
        return parent if parent in self.nodes else 0

    def _with_ancestors(self, uids: Any) -> set[int]:
        found: set[int] = set()
        for uid in uids:
            while uid and uid not in found:
                found.add(uid)
                uid = self._parent(uid)
        return found

    def _found(self) -> list[int]:
        """Return the nodes with the searched text, and their ancestors."""
        wanted = self.search.lower()
        shown = self._with_ancestors(
            uid
            for uid, node in self.nodes.items()
            if wanted in f"{node['name']} {node['registration']}".lower()
        )
        return [uid for uid in self.nodes if uid in shown]

    def _opened(self) -> list[int]:
        """Return the nodes that are not in a folded sub-tree, the folded ones negative.

        Takes no time for the others.
        """
        if self.follow:
            self._followed = self._with_ancestors(self._active)
        shown, stack = [], list(reversed(self._children.get(0, [])))
        while stack:
            uid = stack.pop()
            children = self._children.get(uid)
            if children and not self.is_open(uid):
                uid = -uid
            elif children:
                stack.extend(reversed(children))
            shown.append(uid)
        return shown

    def _first(self, shown: list[int]) -> int:
        """Return the index of the first line below the ancestors."""
        if len(shown) <= (FOLDED_ABOVE if self.follow and not self.search else SHOWN_NODES):
            return 0
        paths = [self.nodes[abs(key)]["path"] for key in shown]
        wanted = self.latest("RUNNING") if self.follow else self.chosen
        return max(0, paths.index(wanted) - LINES_ABOVE) if wanted in paths else 0

    def _line(self, key: int) -> str:
        uid = abs(key)
        node = self.nodes[uid]
        status = self.statuses.get(uid, "IDLE")
        name, kind = escape(node["name"]), escape(node["registration"])
        mark, _ = MARKS.get(status, ("?", ""))
        weight = "bold" if status == "RUNNING" else "normal"
        parts = [f'<b>{mark}</b> <span style="font-weight:{weight}">{name}</span>']
        if kind != name:
            parts.append(f'<span style="opacity:0.6">{kind}</span>')
        if node["path"] in self.breakpoints:
            parts.insert(0, '<span title="breakpoint" style="color:#c92a2a">●</span>')
        if uid in self._children:
            parts.insert(0, "▾" if key > 0 else "▸")
        if reason := self.reasons.get(uid):
            parts.append(f"<i>{escape(reason)}</i>")
        style = (
            f"padding-left:{self._depths[uid]}em;color:{STATUS_COLOURS.get(status, OTHER_COLOUR)}"
        )
        if node["path"] == self.chosen:
            style += ";background:rgba(34,139,230,0.15)"
        self._lines[key] = line = f'<div style="{style}">{" ".join(parts)}</div>'
        return line
