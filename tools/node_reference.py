"""Sections on nodes for the pages of the site, from their documentation and ports."""

import inspect
import re
from collections.abc import Mapping

from bt_manip.bt import BehaviourRegistry, Node, NodeKind

_TITLES = {
    NodeKind.CONTROL: "Control nodes",
    NodeKind.DECORATOR: "Decorators",
    NodeKind.SUBTREE: "Sub-trees",
    NodeKind.ACTION: "Actions",
    NodeKind.CONDITION: "Conditions",
}


def node_reference(nodes: Mapping[str, type[Node]] | None = None) -> str:
    """Describe nodes: their results by the child's status, and their ports.

    Args:
        nodes: The nodes by name; None: those of the language.

    Returns:
        Markdown, one section per kind and one heading per node.
    """
    if nodes is None:
        registry = BehaviourRegistry()
        nodes = {name: registry.get(name) for name in registry.names()}
    sections = []
    for kind, title in _TITLES.items():
        found = [_node(name, cls) for name, cls in nodes.items() if cls.kind is kind]
        if found:
            parts = [f"## {title}", *found]
            sections.append("\n\n".join(parts))
    return "\n\n".join(sections) + "\n"


def _node(name: str, cls: type[Node]) -> str:
    blocks = []
    for block in (inspect.getdoc(cls) or "").split("\n\n"):
        blocks.append(_table(block) if block.startswith("|") else " ".join(block.split("\n")))
    text = [f"### {name}", *(re.sub(r"``(.+?)``", r"`\1`", block) for block in blocks)]
    if cls.ports:
        text.append(_ports(cls))
    return "\n\n".join(text)


def _table(block: str) -> str:
    """Join the rows that a narrow column has broken, and put a header above."""
    rows: list[list[str]] = []
    for line in block.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if set(line) <= set("|-") or cells == ["child", "result"]:
            continue
        if cells[0]:
            rows.append(cells)
        else:
            rows[-1][1] += " " + cells[1]
    head = "child" if rows[0][0] != "tick" else ""
    lines = [f"| {head} | result |", "|---|---|"]
    return "\n".join([*lines, *(f"| {first} | {second} |" for first, second in rows)])


def _ports(cls: type[Node]) -> str:
    lines = ["| port | direction | type | default | |", "|---|---|---|---|---|"]
    for port in cls.ports.values():
        default = f"`{port.default_text}`" if port.default_text else ""
        if port.mandatory:
            default = "required"
        kind = port.type.name.removeprefix("BT::").removeprefix("std::")
        lines.append(
            f"| `{port.name}` | {port.direction} | {kind} | {default} | {port.doc} |".rstrip()
        )
    return "\n".join(lines)
