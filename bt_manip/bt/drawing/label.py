"""What a drawing says of a node."""

from dataclasses import dataclass
from typing import Any

from bt_manip.bt.nodes.node import Node, NodeKind
from bt_manip.bt.nodes.parent import Link, Parent
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.tree import Tree

MARKS = {
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

COLOURS = {
    NodeKind.CONTROL: "#dbe7f5",
    NodeKind.DECORATOR: "#efe3f7",
    NodeKind.SUBTREE: "#e4e4e4",
    NodeKind.ACTION: "#e3f3dd",
    NodeKind.CONDITION: "#fbf1d3",
}
"""Fill of the box of a node, by its kind."""


@dataclass(frozen=True)
class Label:
    """What a drawing says of a node.

    Attributes:
        kind: Its kind.
        registration: The name of its class in trees.
        name: Its own name; empty if it has none.
        details: Its ports and scripts, ``name=value`` each.
        summary: The first line of its documentation.
    """

    kind: NodeKind
    registration: str
    name: str
    details: tuple[str, ...]
    summary: str

    @property
    def title(self) -> str:
        """Its class and its own name."""
        mark = MARKS.get(self.registration)
        head = f"{mark} {self.registration}" if mark else self.registration
        return f'{head} "{self.name}"' if self.name else head


def label_of(link: Link) -> Label:
    """Say of a node what a drawing shows."""
    registration, name = link.registration, link.name
    details: list[str] = []
    summary = ""
    if isinstance(link, SubTree):
        registration = f"SubTree {link.tree_id}"
        name = "" if link.is_unnamed else link.name
        details += [f"{key}={text}" for key, text in link.remaps.items()]
        if link.autoremap:
            details.append("_autoremap=true")
    elif isinstance(link, Node):
        details += [f"{key}={link.port_text(key)}" for key in link.given]
        summary = type(link).summary()
    details += [f"{key}={text}" for key, text in link.conditions.items()]
    return Label(
        link.kind, registration, "" if name == registration else name, tuple(details), summary
    )


def children_of(link: Link, links: dict[int, Any]) -> list[Link]:
    """Give the children of a node as nodes."""
    if isinstance(link, Parent):
        return list(link.links)
    return [links[id(child)] for child in link.children]


def links_by_behaviour(tree: Tree) -> dict[int, Any]:
    """Give the nodes of a tree by the identity of their behaviours."""
    return {id(link if isinstance(link, Node) else link.behaviour): link for link in tree.nodes}
