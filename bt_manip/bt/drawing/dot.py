"""A tree in the language of Graphviz."""

from bt_manip.bt.drawing.label import COLOURS, Label, children_of, label_of, links_by_behaviour
from bt_manip.bt.nodes.node import NodeKind
from bt_manip.bt.nodes.parent import Link
from bt_manip.bt.tree import Tree

_SHAPES = {
    NodeKind.CONTROL: "box",
    NodeKind.DECORATOR: "hexagon",
    NodeKind.SUBTREE: "folder",
    NodeKind.ACTION: "box",
    NodeKind.CONDITION: "ellipse",
}


def draw_dot(tree: Tree, *, ports: bool = True, docs: bool = False) -> str:
    """Write a tree as a directed graph.

    Args:
        tree: The tree.
        ports: Whether to write the ports and scripts of each node.
        docs: Whether to add the first line of each node's documentation as a tool tip.

    Returns:
        The graph in DOT.
    """
    links = links_by_behaviour(tree)
    lines = [
        f"digraph {_quoted(tree.tree_id)} {{",
        "  ordering=out;",
        '  node [style="filled,rounded" fontname="sans-serif" fontsize=11];',
    ]
    _draw(tree.nodes[0], links, lines, ports, docs)
    return "\n".join([*lines, "}"]) + "\n"


def _draw(link: Link, links: dict[int, Link], lines: list[str], ports: bool, docs: bool) -> None:
    label = label_of(link)
    lines.append(f"  n{link.uid} [{_attributes(label, ports, docs)}];")
    for child in children_of(link, links):
        lines.append(f"  n{link.uid} -> n{child.uid};")
        _draw(child, links, lines, ports, docs)


def _attributes(label: Label, ports: bool, docs: bool) -> str:
    text = "\n".join([label.title, *(label.details if ports else ())])
    attributes = {
        "label": text,
        "shape": _SHAPES[label.kind],
        "fillcolor": COLOURS[label.kind],
    }
    if docs and label.summary:
        attributes["tooltip"] = label.summary
    return " ".join(f"{name}={_quoted(value)}" for name, value in attributes.items())


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
