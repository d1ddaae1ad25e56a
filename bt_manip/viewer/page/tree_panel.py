"""The tree as it runs: statuses and reasons, the chosen node, breakpoints, errors of an edit."""

from collections import deque
from collections.abc import Iterable
from html import escape
from typing import Any

from bt_manip.runner import RunEvent

from .node_details import details_html, keep_value
from .panel import Panel, block
from .tree_view import TreeView

NO_NODE = "none"
"""Choice of no node."""

STATUSES = {"Running": "RUNNING", "Failed": "FAILURE"}
"""Statuses of the nodes that these buttons choose."""


class TreePanel(Panel):
    """Shows the tree, which is sent whole and only when it has changed, and the chosen node."""

    in_tab = False

    def __init__(self, page: Any) -> None:
        """Add its inputs to the current container."""
        gui = self._gui = page.server.gui
        self._controls, self._view = page.controls, TreeView()
        self._values: dict[str, Any] = {}  # of the blackboard
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
        self._folder = gui.add_folder("Breakpoints", visible=False)
        self._breakpoints: dict[str, Any] = {}  # buttons that remove them, by path
        self._unset: deque[str] = deque()  # paths of those that were clicked
        self._html = gui.add_html("")

    def reset(self) -> None:
        """Forget statuses, values and errors; the tree follows as an event."""
        self._view.reset()
        self._values.clear()
        self._problems, self._changed = (), True

    def handle(self, event: RunEvent) -> None:
        """Keep nodes, statuses, reasons and values."""
        if event.kind == "edit":
            self._problems, self._changed = event.data["problems"], True
            return
        self._has_new_tree |= event.kind == "tree"
        self._changed |= self._view.handle(event) | keep_value(self._values, event)

    def draw(self) -> None:
        """Send changes."""
        view = self._view
        while self._buttons:
            self._obey(self._buttons.popleft())
        while self._unset:
            self._controls.breakpoints -= {self._unset.popleft()}
        chosen = self._choice.value if self._choice.value != NO_NODE else ""
        if view.chosen != chosen or view.breakpoints != self._controls.breakpoints:
            view.chosen, view.breakpoints = chosen, self._controls.breakpoints
            view.forget_lines()
            self._draw_breakpoints()
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
            details = details_html(node, status, view.reasons.get(node["uid"], ""), self._values)
        problems = "".join(f"<div>{escape(problem)}</div>" for problem in self._problems)
        if problems:
            problems = f"<b>The edited file has errors, the tree goes on as it was:</b>{problems}"
        self._chosen_html.content = block(details, "background:rgba(34,139,230,0.1)")
        self._problem_html.content = block(problems, "color:#c92a2a")
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
            self._controls.breakpoints ^= {node["path"]}
        else:
            view.folds[node["path"]] = view.is_open(node["uid"])
        self._choice.value = path or self._choice.value
        self._changed = True

    def _draw_breakpoints(self) -> None:
        """Add and remove buttons as the breakpoints have changed."""
        wanted, buttons = self._controls.breakpoints, self._breakpoints
        for path in buttons.keys() - wanted:
            buttons.pop(path).remove()
        with self._folder:
            for path in sorted(wanted - buttons.keys()):
                buttons[path] = self._gui.add_button(
                    f"✕ {path}", color="gray", hint="Remove this breakpoint"
                )
                buttons[path].on_click(lambda _, path=path: self._unset.append(path))
        self._folder.visible = bool(wanted)
