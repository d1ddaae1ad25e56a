"""The details of a node as HTML: its ports with their present values."""

from html import escape
from typing import Any

from bt_manip.runner import RunEvent

LONGEST_VALUE = 200
"""Number of characters of a value that are shown."""


def short(value: Any) -> str:
    """Return a value as HTML, cut to `LONGEST_VALUE` characters."""
    text = str(value)
    return escape(text if len(text) <= LONGEST_VALUE else f"{text[:LONGEST_VALUE]}…")


class NodeDetails:
    """Writes path, kind, status, reason and ports of a node.

    Keeps the values of the blackboard from the events of a run.
    """

    def __init__(self) -> None:
        """Start with an empty blackboard."""
        self._values: dict[str, Any] = {}

    def reset(self) -> None:
        """Forget the values."""
        self._values.clear()

    def handle(self, event: RunEvent) -> bool:
        """Take an event; return whether a value has changed."""
        if event.kind != "blackboard":
            return False
        key, value = event.data["key"], event.data["value"]
        if value is None:
            self._values.pop(key, None)
        else:
            self._values[key] = value
        return True

    def html(self, node: dict[str, Any], status: str, reason: str) -> str:
        """Return the details.

        Args:
            node: The node, as in the event ``tree``.
            status: Its status.
            reason: Reason of its failure; empty if it did not fail.
        """
        kind, registration = node["kind"], node["registration"]
        what = kind if kind == registration else f"{kind} {registration}"
        lines = [f"<b>{escape(node['path'])}</b>", f"{escape(what)}, {escape(status.lower())}"]
        if reason:
            lines.append(f"<i>{escape(reason)}</i>")
        rows = [
            f"<tr><td>{escape(port['name'])}</td><td>{escape(port['direction'])}</td>"
            f"<td>{short(port['text'])}{self._entry(port['key'])}</td></tr>"
            for port in node.get("ports", ())
        ]
        if rows:
            style = "border-collapse:separate;border-spacing:0.8em 0;margin-left:-0.8em"
            style += ";overflow-wrap:anywhere;vertical-align:top"
            lines.append(f'<table style="{style}">{"".join(rows)}</table>')
        return "".join(line if line[:2] == "<t" else f"<div>{line}</div>" for line in lines)

    def _entry(self, key: str) -> str:
        """Return key and value of an entry of the blackboard; empty for a port without a key."""
        if not key:
            return ""
        value = short(self._values[key]) if key in self._values else "(not set)"
        return f"<div>{escape(key)} = {value}</div>"
