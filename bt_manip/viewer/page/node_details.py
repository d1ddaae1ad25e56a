"""The details of a node as HTML: its ports with their present values."""

from collections.abc import Mapping
from html import escape
from typing import Any

from bt_manip.runner import RunEvent

SHOWN_CHARACTERS = 200
"""Number of characters of a value that are shown."""


def short(value: Any) -> str:
    """Return a value as HTML, cut to `SHOWN_CHARACTERS` characters."""
    text = str(value)
    return escape(text if len(text) <= SHOWN_CHARACTERS else f"{text[:SHOWN_CHARACTERS]}…")


def keep_value(values: dict[str, Any], event: RunEvent) -> bool:
    """Set or remove a value of the blackboard by its event; return whether it is such an event."""
    if event.kind != "blackboard":
        return False
    key, value = event.data["key"], event.data["value"]
    if value is None:
        values.pop(key, None)
    else:
        values[key] = value
    return True


def details_html(
    node: Mapping[str, Any], status: str, reason: str, values: Mapping[str, Any]
) -> str:
    """Return path, kind, status, reason and ports of a node.

    Args:
        node: The node, as in the event ``tree``.
        status: Its status.
        reason: Reason of its failure; empty if it did not fail.
        values: The blackboard, by key.
    """
    kind, registration = node["kind"], node["registration"]
    kinds = kind if kind == registration else f"{kind} {registration}"
    html = f"<div><b>{escape(node['path'])}</b></div>"
    html += f"<div>{escape(kinds)}, {escape(status.lower())}</div>"
    if reason:
        html += f"<div><i>{escape(reason)}</i></div>"
    rows = [
        f"<tr><td>{escape(port['name'])}</td><td>{escape(port['direction'])}</td>"
        f"<td>{short(port['text'])}{_entry(port['key'], values)}</td></tr>"
        for port in node.get("ports", ())
    ]
    if rows:
        style = "border-collapse:separate;border-spacing:0.8em 0;margin-left:-0.8em"
        style += ";overflow-wrap:anywhere;vertical-align:top"
        html += f'<table style="{style}">{"".join(rows)}</table>'
    return html


def _entry(key: str, values: Mapping[str, Any]) -> str:
    """Return key and value of an entry of the blackboard; empty for a port without a key."""
    value = short(values[key]) if key in values else "(not set)"
    return key and f"<div>{escape(key)} = {value}</div>"
