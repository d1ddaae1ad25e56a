"""The log of a run, and its blackboard, as HTML."""

from collections import deque
from html import escape
from typing import Any

from bt_manip.runner import RunEvent, log_line

from .node_details import short
from .panel import Panel

LINES = 100
"""Number of lines of the log that are kept."""

COLOURS_OF_LEVELS = {"INFO": "inherit", "WARNING": "#e67700", "ERROR": "#c92a2a"}
"""Colour of a line by its level."""

STYLE = "font-size:0.85em;line-height:1.5;padding:0 0.8em;overflow-wrap:anywhere"
"""Style of the text."""


class LogPanel(Panel):
    """Shows reasons of failures, cycles and objects that come and go; the latest line first."""

    def __init__(self, page: Any) -> None:
        """Add it to the current container.

        Args:
            page: The page.
        """
        self._html = page.server.gui.add_html("")
        self._lines: deque[str] = deque(maxlen=LINES)
        self._changed = False

    def reset(self) -> None:
        """Forget the lines."""
        self._lines.clear()
        self._changed = True

    def handle(self, event: RunEvent) -> None:
        """Keep a line for people."""
        if (line := log_line(event)) is not None:
            colour = COLOURS_OF_LEVELS[line[0]]
            text = f"{event.time:.2f} s  {line[1]}"
            self._lines.appendleft(f'<div style="color:{colour}">{escape(text)}</div>')
            self._changed = True

    def draw(self) -> None:
        """Send the log if it has changed."""
        if self._changed:
            self._changed = False
            self._html.content = f'<div style="{STYLE}">{"".join(self._lines)}</div>'


class BlackboardPanel(Panel):
    """Shows the entries of the blackboard, sorted by key."""

    def __init__(self, page: Any) -> None:
        """Add it to the current container.

        Args:
            page: The page.
        """
        self._html = page.server.gui.add_html("")
        self._entries: dict[str, str] = {}
        self._changed = False

    def reset(self) -> None:
        """Forget the entries."""
        self._entries.clear()
        self._changed = True

    def handle(self, event: RunEvent) -> None:
        """Keep the value."""
        if event.kind != "blackboard":
            return
        key, value = event.data["key"], event.data["value"]
        self._changed = True
        if value is None:
            self._entries.pop(key, None)
            return
        self._entries[key] = f"<div><b>{escape(key)}</b> {short(value)}</div>"

    def draw(self) -> None:
        """Send the entries if they have changed."""
        if self._changed:
            self._changed = False
            lines = "".join(self._entries[key] for key in sorted(self._entries))
            self._html.content = f'<div style="{STYLE}">{lines}</div>'
