"""The tree as it runs: statuses and reasons, the chosen node, breakpoints, errors of an edit."""

from collections import deque
from collections.abc import Iterable
from html import escape
from typing import Any

from bt_manip.runner import RunEvent

from .breakpoint_list import BreakpointList
from .node_details import NodeDetails
from .panel import Panel
from .tree_view import TreeView

NO_NODE = "none"
"""Choice of no node."""

STATUSES = {"Running": "RUNNING", "Failed": "FAILURE"}
"""Statuses of the nodes that these buttons choose."""


class TreePanel(Panel):
    """Shows the tree, which is sent whole and only when it has changed, and the chosen node."""

    in_tab = False

    def __init__(self, page: Any) -> None:
        """Add its inputs to the current container.

        Args:
            page: The page.
        """
        gui, self._controls = page.server.gui, page.controls
        self._view, self._details = TreeView(), NodeDetails()
        self._changed = self._has_new_tree = False
        self._problems: Iterable[str] = ()
        self._problem_html = gui.add_html("")
        self._search = gui.add_text("Search", "", hint="Part of a node's name or kind")
        self._follow = gui.add_checkbox(
            "Follow", True, hint="Open the sub-trees of a large tree that run or have failed"
        )
        self._choice = gui.add_dropdown("Node", (NO_NODE,), hint="Node whose ports are shown")
        for inputs in (self._search, self._follow, self._choice):
            inputs.on_update(self._note_change)
        choose = gui.add_button_group(
            "Choose", (*STATUSES, "Parent"), hint="Choose the node that runs or failed last"
        )
        change = gui.add_button_group(
            "Chosen node", ("Breakpoint", "Fold"),
            hint="Set or remove a breakpoint: the run pauses after the tick in which the node "
            "starts. Fold or unfold its sub-tree.",
        )  # fmt: skip
        self._buttons: deque[str] = deque()  # that were clicked
        for group in (choose, change):
            group.on_click(lambda event: self._buttons.append(event.target.value))
        self._chosen_html = gui.add_html("")
        self._breakpoints = BreakpointList(gui, page.controls)
        self._html = gui.add_html("")

    def reset(self) -> None:
        """Forget statuses, values and errors; the tree follows as an event."""
        self._view.reset()
        self._details.reset()
        self._problems, self._changed = (), True

    def handle(self, event: RunEvent) -> None:
        """Keep nodes, statuses, reasons and values."""
        if event.kind == "edit":
            self._problems, self._changed = event.data["problems"], True
            return
        self._has_new_tree |= event.kind == "tree"
        self._changed |= self._view.handle(event) | self._details.handle(event)

    def draw(self) -> None:
        """Send what has changed."""
        view = self._view
        while self._buttons:
            self._obey(self._buttons.popleft())
        chosen = self._choice.value if self._choice.value != NO_NODE else ""
        if view.chosen != chosen or view.breakpoints != self._controls.breakpoints:
            view.chosen, view.breakpoints = chosen, self._controls.breakpoints
            view.forget_lines()
            self._breakpoints.draw()
            self._changed = True
        if not self._changed:
            return
        self._changed = False
        if self._has_new_tree:
            self._has_new_tree = False
            paths = dict.fromkeys(node["path"] for node in view.nodes.values())
            self._choice.options = (NO_NODE, *paths)
        view.search, view.follow = self._search.value.strip(), self._follow.value
        node = view.find(chosen) if chosen else None
        details = ""
        if node is not None:
            status = view.statuses.get(node["uid"], "IDLE")
            details = self._details.html(node, status, view.reasons.get(node["uid"], ""))
        problems = "".join(f"<div>{escape(problem)}</div>" for problem in self._problems)
        if problems:
            problems = f"<b>The edited file has errors, the tree goes on as it was:</b>{problems}"
        _show(self._chosen_html, details, "background:rgba(34,139,230,0.1)")
        _show(self._problem_html, problems, "color:#c92a2a;overflow-wrap:anywhere")
        self._html.content = view.html()

    # Internal

    def _note_change(self, _: Any) -> None:
        self._changed = True

    def _obey(self, button: str) -> None:
        """Choose another node, or change the chosen one."""
        view = self._view
        node = view.find(self._choice.value)
        path = ""
        if button in STATUSES:
            path = view.latest(STATUSES[button])
        elif node is None:
            return
        elif button == "Parent":
            path = view.nodes.get(node["parent"], node)["path"]
        elif button == "Breakpoint":
            self._breakpoints.toggle(node["path"])
        else:
            view.folds[node["path"]] = view.is_open(node["uid"])
        self._choice.value = path or self._choice.value
        self._changed = True


def _show(html: Any, content: str, style: str) -> None:
    """Send a part of the panel if it has changed."""
    if content:
        content = f'<div style="font-size:0.85em;padding:0.2em 0.8em;{style}">{content}</div>'
    if html.content != content:
        html.content = content
