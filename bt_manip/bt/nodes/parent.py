"""What nodes with children have in common."""

from collections.abc import Sequence
from typing import Any

from py_trees.behaviour import Behaviour

from bt_manip.bt.nodes.foreign import ForeignNode
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.remarks import Comment
from bt_manip.bt.status import IDLE, RUNNING

Link = Node | ForeignNode
"""A child as its parent sees it."""


class Parent(Node):
    """A node with children, ours or stock py_trees behaviours."""

    _links_cache: list[Link] | None = None

    def _adopt(self, child: Behaviour) -> None:
        if not isinstance(child, Behaviour):
            raise TypeError(f"children must be behaviours; found {child!r}")
        if child.parent is not None:
            raise RuntimeError(f"'{child.name}' already has the parent '{child.parent.name}'")
        child.parent = self
        self.children.append(child)
        self._links_cache = None

    @property
    def links(self) -> list[Link]:
        """The children as this node ticks them."""
        links = self._links_cache
        if links is None or len(links) != len(self.children):
            links = self._links_cache = [
                child if isinstance(child, Node) else self._foreign(child)
                for child in self.children
            ]
        return links

    def _foreign(self, child: Behaviour) -> ForeignNode:
        link = ForeignNode(child)
        link._node_runtime = self._node_runtime
        link._node_observers = self._node_observers
        return link

    def _reset_children(self) -> None:
        """Halt the children that run, and set all to idle."""
        watched = bool(self._node_observers)
        for link in self._links_cache or self.links:
            status = link._node_status
            if status is RUNNING:
                link.halt()
                link._reset()
            elif status is not IDLE:
                if watched:
                    link._reset()
                else:
                    link._node_status = IDLE

    def _halt_child(self, index: int) -> None:
        link = self.links[index]
        if link._node_status is RUNNING:
            link.halt()
        link._reset()

    def _halt(self) -> None:
        self._reset_children()
        self._reset()

    def stop(self, new_status: Any) -> None:
        """Stop the node and its children for a stock py_trees parent."""
        super().stop(new_status)

    def tip(self) -> Behaviour | None:
        """Give the deepest node that decided this node's present status."""
        for child in reversed(self.children):
            if child.status is self.status or child.status.name == "RUNNING":
                tip = child.tip()
                if tip is not None:
                    return tip
        return Behaviour.tip(self)


def name_and_children(
    args: tuple[Any, ...], children: Sequence[Behaviour | Comment] | None
) -> tuple[str | None, list[Behaviour], list[tuple[int, Comment]]]:
    """Sort positional arguments into a name, children and comments.

    Args:
        args: Optionally a name, then children, each by itself or in lists.
        children: More children.

    Raises:
        TypeError: If something else is among them.
    """
    name: str | None = None
    rest = list(args)
    if rest and (isinstance(rest[0], str) or rest[0] is None):
        name = rest.pop(0)
    found: list[Behaviour] = []
    remarks: list[tuple[int, Comment]] = []
    for item in [*rest, *(children or ())]:
        items = item if isinstance(item, list | tuple) else [item]
        for child in items:
            if isinstance(child, Comment):
                remarks.append((len(found), child))
                continue
            if not isinstance(child, Behaviour):
                raise TypeError(f"expected a name and children; found {child!r}")
            found.append(child)
    return name, found, remarks
