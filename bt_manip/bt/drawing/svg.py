"""A tree as an SVG picture, laid out from the root down."""

from dataclasses import dataclass, field

from bt_manip.bt.drawing.label import COLOURS, Label, children_of, label_of, links_by_behaviour
from bt_manip.bt.nodes.parent import Link
from bt_manip.bt.tree import Tree
from bt_manip.bt.xml.writer import escape

_CHARACTER = 6.6  # [px], mean width of one at the font size below
_LINE = 15.0  # [px]
_PADDING = 8.0  # [px]
_GAP_X = 14.0  # [px]
_GAP_Y = 34.0  # [px]


@dataclass
class _Box:
    label: Label
    lines: list[str]
    children: "list[_Box]" = field(default_factory=list)
    x: float = 0.0
    y: float = 0.0
    span: float = 0.0

    @property
    def width(self) -> float:
        return max(len(line) for line in self.lines) * _CHARACTER + 2 * _PADDING

    @property
    def height(self) -> float:
        return len(self.lines) * _LINE + 2 * _PADDING


def draw_svg(tree: Tree, *, ports: bool = True, docs: bool = False) -> str:
    """Draw a tree as a picture.

    Args:
        tree: The tree.
        ports: Whether to write the ports and scripts of each node.
        docs: Whether to add the first line of each node's documentation as a tool tip.

    Returns:
        The picture as SVG.
    """
    root = _box(tree.nodes[0], links_by_behaviour(tree), ports)
    _measure(root)
    bottom = _place(root, _GAP_X, _GAP_X)
    body: list[str] = []
    _draw(root, body, docs)
    width, height = root.span + 2 * _GAP_X, bottom + _GAP_X
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}" font-family="sans-serif" font-size="12">\n'
        + "\n".join(body)
        + "\n</svg>\n"
    )


def _box(link: Link, links: dict[int, Link], ports: bool) -> _Box:
    label = label_of(link)
    box = _Box(label, [label.title, *(label.details if ports else ())])
    box.children = [_box(child, links, ports) for child in children_of(link, links)]
    return box


def _measure(box: _Box) -> None:
    for child in box.children:
        _measure(child)
    below = sum(child.span for child in box.children) + _GAP_X * max(len(box.children) - 1, 0)
    box.span = max(box.width, below)


def _place(box: _Box, left: float, top: float) -> float:
    """Give a box and all below their places; return how far down they reach."""
    box.x = left + (box.span - box.width) / 2
    box.y = top
    below = sum(child.span for child in box.children) + _GAP_X * max(len(box.children) - 1, 0)
    left += (box.span - below) / 2
    bottom = top + box.height
    for child in box.children:
        bottom = max(bottom, _place(child, left, top + box.height + _GAP_Y))
        left += child.span + _GAP_X
    return bottom


def _draw(box: _Box, body: list[str], docs: bool) -> None:
    centre = box.x + box.width / 2
    for child in box.children:
        end = child.x + child.width / 2
        middle = (box.y + box.height + child.y) / 2
        body.append(
            f'<path d="M{centre:.1f},{box.y + box.height:.1f} V{middle:.1f} H{end:.1f} '
            f'V{child.y:.1f}" fill="none" stroke="#888"/>'
        )
    title = f"<title>{escape(box.label.summary)}</title>" if docs and box.label.summary else ""
    body.append(
        f'<g>{title}<rect x="{box.x:.1f}" y="{box.y:.1f}" width="{box.width:.1f}" '
        f'height="{box.height:.1f}" rx="6" fill="{COLOURS[box.label.kind]}" stroke="#666"/>'
    )
    for index, line in enumerate(box.lines):
        weight = ' font-weight="bold"' if index == 0 else ' fill="#444"'
        y = box.y + _PADDING + (index + 0.8) * _LINE
        body.append(
            f'<text x="{centre:.1f}" y="{y:.1f}" text-anchor="middle"{weight}>'
            f"{escape(line, quotes=False)}</text>"
        )
    body.append("</g>")
    for child in box.children:
        _draw(child, body, docs)
