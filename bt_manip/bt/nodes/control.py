"""Nodes with several children."""

import uuid
from collections.abc import Sequence
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.composites import Composite

from bt_manip.bt.nodes.node import Node, NodeKind
from bt_manip.bt.nodes.parent import Parent, name_and_children
from bt_manip.bt.status import IDLE, RUNNING, Status


class Control(Parent, Composite):  # type: ignore[misc]  # stop() needs a status in both
    """A node that directs several children.

    A new control node implements ``_tick``: it ticks ``self.links[i].execute()`` and returns a
    `NodeStatus`. It calls ``self._enter()`` first, and ``self._reset_children()`` when it is done.
    """

    kind: ClassVar = NodeKind.CONTROL
    least_children: ClassVar[int] = 1
    most_children: ClassVar[int | None] = None

    def __init__(
        self, *args: Any, children: Sequence[Behaviour] | None = None, **ports: Any
    ) -> None:
        """Configure the node.

        Args:
            *args: Optionally its name, then its children, singly or as a list.
            children: Its children.
            **ports: As of every `Node`.
        """
        name, found, remarks = name_and_children(args, children)
        Node.__init__(self, name, **ports)
        self.remarks = remarks
        self.current_child = None
        for child in found:
            self._adopt(child)

    def _enter(self) -> None:
        """Become running; what py_trees shows of an earlier round is wiped."""
        status = self._node_status
        if status is not RUNNING:
            if status is IDLE:
                for child in self.children:
                    child.status = _INVALID
            if self._node_observers:
                self._set_status(RUNNING)
            else:
                self._node_status = RUNNING
            self.status = _RUNNING

    # py_trees' ways to change the children

    def add_child(self, child: Behaviour) -> uuid.UUID:
        """Append a child."""
        self._adopt(child)
        return child.id

    def insert_child(self, child: Behaviour, index: int) -> uuid.UUID:
        """Insert a child at an index."""
        self._links_cache = None
        return Composite.insert_child(self, child, index)

    def prepend_child(self, child: Behaviour) -> uuid.UUID:
        """Insert a child before all others."""
        return self.insert_child(child, 0)

    def remove_child(self, child: Behaviour) -> int:
        """Remove a child; it is stopped if it runs."""
        self._links_cache = None
        return Composite.remove_child(self, child)

    def remove_all_children(self) -> None:
        """Remove all children; those that run are stopped."""
        self._links_cache = None
        Composite.remove_all_children(self)


_INVALID = Status.INVALID
_RUNNING = Status.RUNNING
