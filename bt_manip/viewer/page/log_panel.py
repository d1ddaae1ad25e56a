"""The log of a run, and its blackboard, as HTML."""

from collections import deque
from html import escape
from typing import Any

from bt_manip.runner import RunEvent, log_line

from .node_details import keep_value, short
from .panel import Panel, block

LINES = 100
"""Number of lines of the log that are kept."""

COLOURS_OF_LEVELS = {"INFO": "inherit", "WARNING": "#e67700", "ERROR": "#c92a2a"}
"""Colour of a line by its level."""

STYLE = "line-height:1.5"
"""Style of the text."""


class LogPanel(Panel):
    """Shows reasons of failures, cycles and objects that come and go; the latest line first."""

    def __init__(self, page: Any) -> None:
        """Add it to the current container."""
        self._html = page.server.gui.add_html("")
        self._lines: deque[str] = deque(maxlen=LINES)

    def reset(self) -> None:
        """Forget the lines."""
        self._lines.clear()

    def handle(self, event: RunEvent) -> None:
        """Keep a line for people."""
        if (line := log_line(event)) is not None:
            colour = COLOURS_OF_LEVELS[line[0]]
            text = f"{event.time:.2f} s  {line[1]}"
            self._lines.appendleft(f'<div style="color:{colour}">{escape(text)}</div>')

    def draw(self) -> None:
        """Send the log if it has changed."""
        self._html.content = block("".join(self._lines), STYLE)


class BlackboardPanel(Panel):
    """Shows the entries of the blackboard, sorted by key."""

    def __init__(self, page: Any) -> None:
        """Add it to the current container."""
        self._html = page.server.gui.add_html("")
        self._values: dict[str, Any] = {}
        self._changed = False

    def reset(self) -> None:
        """Forget the entries."""
        self._values.clear()
        self._changed = True

    def handle(self, event: RunEvent) -> None:
        """Keep the value."""
        self._changed |= keep_value(self._values, event)

    def draw(self) -> None:
        """Send the entries if they have changed."""
        if self._changed:
            self._changed = False
            entries = sorted(self._values.items())
            lines = [f"<div><b>{escape(key)}</b> {short(value)}</div>" for key, value in entries]
            self._html.content = block("".join(lines), STYLE)
