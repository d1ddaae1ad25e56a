"""Drawing trees: as text for a terminal, as DOT for Graphviz, and as SVG."""

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.parent import Parent
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.nodes.tree_node import NodeKind, TreeNode, behaviour_of
from bt_manip.bt.xml.writer import escape

if TYPE_CHECKING:
    from bt_manip.bt.tree import Tree

NODE_MARKS = {
    "Sequence": "→",
    "AsyncSequence": "→",
    "SequenceWithMemory": "→*",
    "ReactiveSequence": "→°",
    "Fallback": "?",
    "AsyncFallback": "?",
    "ReactiveFallback": "?°",
    "Parallel": "⇉",
    "ParallelAll": "⇉",
}
"""Signs of the control nodes that have an established one."""

_STYLES = {
    NodeKind.CONTROL: ("box", "#dbe7f5"),
    NodeKind.DECORATOR: ("hexagon", "#efe3f7"),
    NodeKind.SUBTREE: ("folder", "#e4e4e4"),
    NodeKind.ACTION: ("box", "#e3f3dd"),
    NodeKind.CONDITION: ("ellipse", "#fbf1d3"),
}
"""Shape in Graphviz and fill colour of a node, by its kind."""

STATUS_COLOURS = {"RUNNING": "#e67700", "SUCCESS": "#2b8a3e", "FAILURE": "#c92a2a"}
"""Colour of each status in which a node has run, by its name."""

_CHARACTER = 6.6  # [px], mean width of one at the font size of the SVG
_ROW = 19.0  # [px]
_INDENT = 18.0  # [px] of a level
_PADDING = 8.0  # [px]


@dataclass
class _Box:
    """The text of a node, with those below.

    Attributes:
        node: The node.
        title: Its class and its own name.
        details: Its ports and scripts, ``name=value`` each.
        summary: The first line of its documentation.
        children: The boxes of its children.
    """

    node: TreeNode
    title: str
    details: list[str]
    summary: str = ""
    children: "list[_Box]" = field(default_factory=list)


def draw_text(tree: "Tree", *, ports: bool = True, docs: bool = False) -> str:
    """Draw a tree for a terminal.

    Args:
        tree: The tree.
        ports: Whether to write the ports and scripts of each node.
        docs: Whether to write the first line of each leaf's documentation.

    Returns:
        The drawing, one line per node.
    """
    lines = [tree.tree_id]
    _draw_lines(_layout(tree, ports), "", True, lines, docs)
    return "\n".join(lines) + "\n"


def _draw_lines(box: _Box, indent: str, last: bool, lines: list[str], docs: bool) -> None:
    details = "  " + " ".join(box.details) if box.details else ""
    lines.append(indent + ("└─ " if last else "├─ ") + box.title + details)
    indent += "   " if last else "│  "
    if docs and box.summary and not box.children:
        lines.append(f"{indent}   {box.summary}")
    for child in box.children:
        _draw_lines(child, indent, child is box.children[-1], lines, docs)


def draw_dot(tree: "Tree", *, ports: bool = True, docs: bool = False) -> str:
    """Write a tree as a directed graph in DOT; `docs` are tool tips, see `draw_text`."""
    lines = [
        f"digraph {_quoted(tree.tree_id)} {{",
        "  ordering=out;",
        '  node [style="filled,rounded" fontname="sans-serif" fontsize=11];',
    ]
    _draw_edges(_layout(tree, ports), lines, docs)
    return "\n".join([*lines, "}"]) + "\n"


def _draw_edges(box: _Box, lines: list[str], docs: bool) -> None:
    shape, colour = _STYLES[box.node.kind]
    attributes = {
        "label": "\n".join([box.title, *box.details]),
        "shape": shape,
        "fillcolor": colour,
    }
    if docs and box.summary:
        attributes["tooltip"] = box.summary
    text = " ".join(f"{name}={_quoted(value)}" for name, value in attributes.items())
    lines.append(f"  n{box.node.uid} [{text}];")
    for child in box.children:
        lines.append(f"  n{box.node.uid} -> n{child.node.uid};")
        _draw_edges(child, lines, docs)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def draw_svg(tree: "Tree", *, ports: bool = True, docs: bool = False) -> str:
    """Draw a tree as SVG, a line for each node: its kind, name, ports, status and reason.

    `docs` are tool tips, see `draw_text`.
    """
    body: list[str] = []
    rows, width = _draw_rows(_layout(tree, ports), _PADDING, 0, body, docs)
    width, height = width + 2 * _PADDING, rows * _ROW + 2 * _PADDING
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="12" '
        'style="background:white">\n' + "\n".join(body) + "\n</svg>\n"
    )


def _draw_rows(box: _Box, x: float, row: int, body: list[str], docs: bool) -> tuple[int, float]:
    """Draw a node and all below, a row each; return the next row and the right edge [px]."""
    y = _PADDING + (row + 0.5) * _ROW
    status = box.node.engine_status
    colour, state, reason = STATUS_COLOURS.get(status.name, "#333"), "", ""
    if status.name in STATUS_COLOURS:
        state, reason = status.name, getattr(behaviour_of(box.node), "feedback_message", "")
    details = " ".join(box.details)
    summary = f"<title>{escape(box.summary)}</title>" if docs and box.summary else ""
    body.append(
        f'<rect x="{x:.0f}" y="{y - 5:.1f}" width="10" height="10" rx="2" '
        f'fill="{_STYLES[box.node.kind][1]}" stroke="{colour}"/>'
        f'<text x="{x + 16:.0f}" y="{y + 4:.1f}" fill="{colour}">{summary}{escape(box.title)} '
        f'<tspan fill="#666">{escape(details)}</tspan> '
        f'<tspan font-weight="bold">{state}</tspan> {escape(reason)}</text>'
    )
    edge = x + len(f"{box.title} {details} {state} {reason}") * _CHARACTER + 16
    row += 1
    for child in box.children:
        end = _PADDING + (row + 0.5) * _ROW
        body.append(f'<path d="M{x + 5:.0f},{end:.1f} h{_INDENT - 5:.0f}" stroke="#aaa"/>')
        row, right = _draw_rows(child, x + _INDENT, row, body, docs)
        edge = max(edge, right)
    if box.children:
        body.append(f'<path d="M{x + 5:.0f},{y + 5:.1f} V{end:.1f}" stroke="#aaa"/>')
    return row, edge


def _layout(tree: "Tree", ports: bool) -> _Box:
    nodes = {id(behaviour_of(node)): node for node in tree.nodes}
    return _box(tree.nodes[0], nodes, ports)


def _box(node: TreeNode, nodes: dict[int, TreeNode], ports: bool) -> _Box:
    registration, name = node.registration, node.name
    details: list[str] = []
    summary = ""
    if isinstance(node, SubTree):
        registration = f"SubTree {node.tree_id}"
        name = "" if node.is_unnamed else node.name
        details += [f"{key}={text}" for key, text in node.remaps.items()]
        if node.autoremap:
            details.append("_autoremap=true")
    elif isinstance(node, Node):
        details += [f"{key}={node.port_text(key)}" for key in node.given]
        summary = type(node).summary()
    details += [f"{key}={text}" for key, text in node.conditions.items()]
    mark = NODE_MARKS.get(registration)
    title = f"{mark} {registration}" if mark else registration
    if name and name != registration:
        title += f' "{name}"'
    box = _Box(node, title, details if ports else [], summary)
    inner = node.child_nodes if isinstance(node, Parent) else [nodes[id(c)] for c in node.children]
    box.children = [_box(child, nodes, ports) for child in inner]
    return box
