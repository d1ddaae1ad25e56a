"""Nodes around one child."""

from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.decorators import Decorator as PyTreesDecorator

from bt_manip.bt.nodes.node import Node, NodeKind
from bt_manip.bt.nodes.parent import Link, Parent, name_and_children
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SUCCESS, NodeStatus, Status


class Decorator(Parent, PyTreesDecorator):
    """A node that changes what one child does or what comes of it.

    A new decorator implements ``_tick``: it ticks ``self.link.execute()`` and returns a
    `NodeStatus`. A child that has completed is reset after the tick.
    """

    kind: ClassVar = NodeKind.DECORATOR

    def __init__(self, *args: Any, child: Behaviour | None = None, **ports: Any) -> None:
        """Configure the node.

        Args:
            *args: Optionally its name, then its child.
            child: Its child.
            **ports: As of every `Node`.

        Raises:
            TypeError: If there is more than one child.
        """
        name, found, remarks = name_and_children(args, None if child is None else [child])
        if len(found) > 1:
            raise TypeError(f"{type(self).__name__} takes one child; found {len(found)}")
        Node.__init__(self, name, **ports)
        self.remarks = remarks
        for one in found:
            self._adopt(one)

    @property
    def decorated(self) -> Behaviour:  # type: ignore[override]
        """The child, by py_trees' name."""
        return self.children[0]

    @property
    def link(self) -> Link:
        """The child as this node ticks it."""
        return (self._links_cache or self.links)[0]

    def execute(self) -> NodeStatus:
        """Tick the node and its child, and give the result."""
        state = Node.execute(self)
        link = self.link
        status = link._node_status
        if status is SUCCESS or status is FAILURE:
            link._reset()
        return state

    def _enter(self) -> None:
        """Become running; what py_trees shows of an earlier round is wiped."""
        if self._node_status is not RUNNING:
            if self._node_status is IDLE:
                self.children[0].status = _INVALID
            self._set_status(RUNNING)
            self.status = _RUNNING

    def _reset_child(self) -> None:
        """Halt the child if it runs, and set it to idle."""
        link = self.link
        if link._node_status is RUNNING:
            link.halt()
        link._reset()


_INVALID = Status.INVALID
_RUNNING = Status.RUNNING
