"""A tree as text, with lines from parents to children."""

from bt_manip.bt.drawing.label import Label, children_of, label_of, links_by_behaviour
from bt_manip.bt.nodes.parent import Link
from bt_manip.bt.tree import Tree


def draw_text(tree: Tree, *, ports: bool = True, docs: bool = False) -> str:
    """Draw a tree for a terminal.

    Args:
        tree: The tree.
        ports: Whether to write the ports and scripts of each node.
        docs: Whether to write the first line of each leaf's documentation.

    Returns:
        The drawing, a line a node.
    """
    lines = [tree.tree_id]
    links = links_by_behaviour(tree)
    _draw(tree.nodes[0], "", True, lines, links, ports, docs)
    return "\n".join(lines) + "\n"


def _draw(
    link: Link,
    indent: str,
    last: bool,
    lines: list[str],
    links: dict[int, Link],
    ports: bool,
    docs: bool,
) -> None:
    label = label_of(link)
    lines.append(indent + ("└─ " if last else "├─ ") + _line(label, ports))
    indent += "   " if last else "│  "
    children = children_of(link, links)
    if docs and label.summary and not children:
        lines.append(f"{indent}   {label.summary}")
    for index, child in enumerate(children):
        _draw(child, indent, index == len(children) - 1, lines, links, ports, docs)


def _line(label: Label, ports: bool) -> str:
    details = "  " + " ".join(label.details) if ports and label.details else ""
    return label.title + details
