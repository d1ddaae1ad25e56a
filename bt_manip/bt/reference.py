"""The reference of all nodes as Markdown, made from their documentation and their ports."""

import inspect
import re
import sys
from pathlib import Path

from bt_manip.bt.nodes.node import Node, NodeKind
from bt_manip.bt.registry import BehaviourRegistry

_TITLES = {
    NodeKind.CONTROL: "Control nodes",
    NodeKind.DECORATOR: "Decorators",
    NodeKind.SUBTREE: "Sub-trees",
    NodeKind.ACTION: "Actions",
    NodeKind.CONDITION: "Conditions",
}


def node_reference(registry: BehaviourRegistry, *, built_in: bool = True) -> str:
    """Describe all nodes: what each does with its child's status, and its ports.

    Args:
        registry: The nodes.
        built_in: Whether the nodes of the language are described, or those beyond them.

    Returns:
        Markdown, a section a kind and a heading a node.
    """
    names = [name for name in registry.names() if registry.is_built_in(name) == built_in]
    sections = []
    for kind, title in _TITLES.items():
        nodes = [name for name in names if registry.get(name).kind is kind]
        if nodes:
            parts = [f"## {title}", *(_node(name, registry.get(name)) for name in nodes)]
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
        if set(line) <= set("|-") or cells == ["child", "what happens"]:
            continue
        if cells[0]:
            rows.append(cells)
        else:
            rows[-1][1] += " " + cells[1]
    head = "child" if rows[0][0] != "tick" else ""
    lines = [f"| {head} | what happens |", "|---|---|"]
    return "\n".join([*lines, *(f"| {first} | {second} |" for first, second in rows)])


def _ports(cls: type[Node]) -> str:
    lines = ["| port | direction | type | default | |", "|---|---|---|---|---|"]
    for port in cls.ports.values():
        default = f"`{port.default_text}`" if port.default_text else ""
        kind = port.type.name.removeprefix("BT::").removeprefix("std::")
        lines.append(
            f"| `{port.name}` | {port.direction} | {kind} | {default} | {port.doc} |".rstrip()
        )
    return "\n".join(lines)


def replace_reference(page: str, registry: BehaviourRegistry) -> str:
    """Give a page with its sections of nodes written anew.

    Args:
        page: A page that holds such sections, from ``## Control nodes`` to ``## Dialects``.
        registry: The nodes.
    """
    start = page.index("## Control nodes")
    end = page.index("## Dialects")
    return page[:start] + node_reference(registry) + "\n" + page[end:]


if __name__ == "__main__":
    file = Path(sys.argv[1])
    text = replace_reference(file.read_text(encoding="utf-8"), BehaviourRegistry())
    file.write_text(text, encoding="utf-8")
