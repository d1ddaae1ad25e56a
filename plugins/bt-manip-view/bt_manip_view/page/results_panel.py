"""Results that a tree declares, in each cycle."""

from collections import deque
from html import escape
from typing import Any

from bt_manip.runner import RunEvent

from .panel import Panel

CYCLES = 20
"""Number of cycles that are shown, the last ones."""


class ResultsPanel(Panel):
    """Shows the results of the present cycle and of those before; nothing without results."""

    place = "left"

    def __init__(self, page: Any) -> None:
        self._html = page.gui.add("html", content="", visible=False)
        self.reset()

    def reset(self) -> None:
        """Forget all cycles."""
        self._keys: list[str] = []
        self._values: dict[str, Any] = {}
        self._rows: deque[tuple[str, list[Any]]] = deque(maxlen=CYCLES)
        self._cycle = ""  # that runs

    def handle(self, event: RunEvent) -> None:
        """Store the declared results and their values."""
        data = event.data
        if event.kind == "tree":
            self._keys = data.get("results", [])  # older recordings have none
        elif event.kind == "blackboard":
            self._values[data["key"]] = data["value"]
        elif event.kind == "cycle":
            self._cycle = f"cycle {data['cycle'] + 1}"
            if data["status"] != "RUNNING":
                self._rows.append((f"{self._cycle} {data['status']}", self._present))
                self._cycle = ""

    def draw(self) -> None:
        """Send the table."""
        rows = [*self._rows, (self._cycle, self._present)] if self._cycle else list(self._rows)
        self._html.visible = bool(self._keys and rows)
        self._html.content = _table(["results", *self._keys], rows[::-1])

    @property
    def _present(self) -> list[Any]:
        return [self._values.get(key) for key in self._keys]


def _table(head: list[str], rows: list[tuple[str, list[Any]]]) -> str:
    """Return a table as HTML."""
    lines = ["".join(f"<th>{escape(title)}</th>" for title in head)]
    for title, values in rows:
        cells = [title, *map(_text, values)]
        lines.append("".join(f"<td>{escape(cell)}</td>" for cell in cells))
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f'<div class="results"><table>{body}</table></div>'


def _text(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
