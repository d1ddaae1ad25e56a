"""Nodes with children: Control with several, Decorator with one."""

import uuid
from collections.abc import Sequence
from typing import Any, ClassVar, Final

from py_trees.behaviour import Behaviour
from py_trees.composites import Composite
from py_trees.decorators import Decorator as PyTreesDecorator

from bt_manip.bt.nodes.node import Comment, Node, NodeKind
from bt_manip.bt.nodes.tree_node import ForeignNode, TreeNode
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SUCCESS, NodeStatus, Status

_INVALID: Final = Status.INVALID
_RUNNING: Final = Status.RUNNING


class Parent(Node):
    """A node with children, ours or stock py_trees behaviours."""

    _child_nodes: list[TreeNode] | None = None

    def _configure(self, args: tuple[Any, ...], more: Sequence[Any], ports: dict[str, Any]) -> None:
        """Take an optional name, then children and comments, each by itself or in lists."""
        name: str | None = None
        if args and (args[0] is None or isinstance(args[0], str)):
            name, *args = args  # type: ignore[assignment]
        children: list[Behaviour] = []
        comments: list[tuple[int, Comment]] = []
        for item in (*args, *more):
            for child in item if isinstance(item, list | tuple) else (item,):
                if isinstance(child, Comment):
                    comments.append((len(children), child))
                else:
                    children.append(child)
        if self.kind is not NodeKind.CONTROL and len(children) > 1:
            raise TypeError(f"{type(self).__name__} takes one child; found {len(children)}")
        Node.__init__(self, name, **ports)
        self._node_comments = comments
        for child in children:
            self._adopt(child)

    def _adopt(self, child: Behaviour) -> None:
        if not isinstance(child, Behaviour):
            raise TypeError(f"expected a name and children; found {child!r}")
        if child.parent is not None:
            raise RuntimeError(f"'{child.name}' already has the parent '{child.parent.name}'")
        child.parent = self
        self.children.append(child)
        self._child_nodes = None

    @property
    def child_nodes(self) -> list[TreeNode]:
        """The children as this node ticks them."""
        nodes = self._child_nodes
        if nodes is None or len(nodes) != len(self.children):
            nodes = self._child_nodes = [
                child if isinstance(child, Node) else self._foreign(child)
                for child in self.children
            ]
        return nodes

    def _foreign(self, child: Behaviour) -> ForeignNode:
        node = ForeignNode(child)
        node._node_runtime = self._node_runtime
        node._node_observers = self._node_observers
        return node

    def _enter(self) -> None:
        """Become running; py_trees' statuses of an earlier round are reset."""
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

    def _reset_children(self) -> None:
        """Halt the running children, and set all to idle."""
        watched = bool(self._node_observers)
        for child in self._child_nodes or self.child_nodes:
            status = child._node_status
            if status is RUNNING:
                child.halt()
                child._reset()
            elif status is not IDLE:
                if watched:
                    child._reset()
                else:
                    child._node_status = IDLE

    def _halt_child(self, index: int) -> None:
        child = self.child_nodes[index]
        if child._node_status is RUNNING:
            child.halt()
        child._reset()

    def _halt(self) -> None:
        self._reset_children()
        self._reset()

    def tip(self) -> Behaviour | None:
        """Return the deepest node that decided this node's present status."""
        for child in reversed(self.children):
            if child.status is self.status or child.status is _RUNNING:
                tip = child.tip()
                if tip is not None:
                    return tip
        return Behaviour.tip(self)


class Control(Parent, Composite):  # type: ignore[misc]  # stop() needs a status in both
    """A node that directs several children.

    A new control node implements ``_tick``: it ticks ``self.child_nodes[i].execute()`` and returns
    a `NodeStatus`. It calls ``self._enter()`` first, and ``self._reset_children()`` at the end.

    Args:
        *args: Optionally its name, then its children, singly or as a list.
        children: Its children.
        **ports: As of every `Node`.

    Raises:
        TypeError: If something else is among the children.
    """

    kind: ClassVar = NodeKind.CONTROL
    least_children: ClassVar[int] = 1
    most_children: ClassVar[int | None] = None

    def __init__(
        self, *args: Any, children: Sequence[Behaviour] | None = None, **ports: Any
    ) -> None:
        self._configure(args, children or (), ports)
        self.current_child = None

    def add_child(self, child: Behaviour) -> uuid.UUID:
        """Append a child."""
        self._adopt(child)
        return child.id

    def insert_child(self, child: Behaviour, index: int) -> uuid.UUID:
        """Insert a child at an index."""
        self._child_nodes = None
        return Composite.insert_child(self, child, index)

    def prepend_child(self, child: Behaviour) -> uuid.UUID:
        """Insert a child before all others."""
        return self.insert_child(child, 0)

    def remove_child(self, child: Behaviour) -> int:
        """Remove a child; it is stopped if it runs."""
        self._child_nodes = None
        return Composite.remove_child(self, child)

    def remove_all_children(self) -> None:
        """Remove all children; running children are stopped."""
        self._child_nodes = None
        Composite.remove_all_children(self)


class Decorator(Parent, PyTreesDecorator):
    """A node that changes the ticks or the result of one child.

    A new decorator implements ``_tick``: it ticks ``self.child_node.execute()`` and returns a
    `NodeStatus`. A child that has completed is reset after the tick.

    Args:
        *args: Optionally its name, then its child.
        child: Its child.
        **ports: As of every `Node`.

    Raises:
        TypeError: If there is more than one child.
    """

    kind: ClassVar = NodeKind.DECORATOR

    def __init__(self, *args: Any, child: Behaviour | None = None, **ports: Any) -> None:
        self._configure(args, () if child is None else (child,), ports)

    @property
    def decorated(self) -> Behaviour:  # type: ignore[override]
        """The child, by py_trees' name."""
        return self.children[0]

    @property
    def child_node(self) -> TreeNode:
        """The child as this node ticks it."""
        return (self._child_nodes or self.child_nodes)[0]

    def execute(self) -> NodeStatus:
        """Tick the node and its child, and return the result."""
        state = Node.execute(self)
        child = self.child_node
        status = child._node_status
        if status is SUCCESS or status is FAILURE:
            child._reset()
        return state

    def _reset_child(self) -> None:
        """Halt the child if it runs, and set it to idle."""
        child = self.child_node
        if child._node_status is RUNNING:
            child.halt()
        child._reset()
