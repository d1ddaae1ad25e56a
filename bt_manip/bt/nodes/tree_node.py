"""A node as its parent and its tree see it: one of ours, or a stock py_trees behaviour."""

import copy
from collections.abc import Mapping
from enum import StrEnum
from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.behaviour import Behaviour

from bt_manip.bt.ports import Port
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, NodeStatus, Status, node_status
from bt_manip.exceptions import NodeError

if TYPE_CHECKING:
    from bt_manip.bt.runtime import Observer, Runtime


class NodeKind(StrEnum):
    """The kind of a node, by the names of the elements of a tree document."""

    ACTION = "Action"
    CONDITION = "Condition"
    CONTROL = "Control"
    DECORATOR = "Decorator"
    SUBTREE = "SubTree"


class TreeNode:
    """The interface and the status that nodes and wrapped py_trees behaviours share.

    Attributes:
        kind: Which element of a document it is.
        ports: Its ports by name.
        registration: The name under which trees know its class.
        memory: Names of the attributes that make up its state over time, all of them plain data.
        reports_time: Whether reports say in how many cycles it ran, for which share of the time,
            and why not longer: for leaves that others replace where they fail, as a policy.
        drawn: Names of the outputs whose values it draws at random, which reports keep.
        orphans: Children of the node that a test replaced by this one; they are never ticked.
        path: Its path in its tree: the sub-trees that lead to it, and its name.
        uid: Its number in its tree, from 1, depth first.
    """

    kind: ClassVar[NodeKind]
    ports: ClassVar[Mapping[str, Port]] = {}
    registration: str = ""
    memory: ClassVar[tuple[str, ...]] = ()
    reports_time: ClassVar[bool] = False
    drawn: ClassVar[tuple[str, ...]] = ()
    orphans: tuple[Behaviour, ...] = ()
    path: str = ""
    uid: int = 0
    name: str
    children: list[Behaviour]
    feedback_message: str
    status: Status
    conditions: dict[str, str]
    _node_place: object = ""  # in its document
    _node_status: NodeStatus
    _node_runtime: "Runtime | None"
    _node_observers: "list[Observer] | tuple[()]"

    @property
    def child_nodes(self) -> list[Any]:
        """The children as this node ticks them; leaves have none."""
        return []

    @property
    def engine_status(self) -> NodeStatus:
        """The engine's status of the node: idle again as soon as its parent has completed."""
        return self._node_status

    def execute(self) -> NodeStatus:
        """Tick the node and its children, and return the result."""
        raise NotImplementedError

    def halt(self) -> None:
        """Interrupt the node and its running children."""
        raise NotImplementedError

    def _reset(self) -> None:
        self._set_status(IDLE)

    def _set_status(self, new: NodeStatus) -> None:
        old = self._node_status
        if old is not new:
            self._node_status = new
            for observer in self._node_observers:
                observer(self, old, new)

    def get_state(self) -> dict[str, Any]:
        """Return a copy of the state that the node keeps between two ticks, as plain data."""
        return {name: copy.deepcopy(getattr(self, name)) for name in self.memory}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state that `get_state` returned."""
        for name in self.memory:
            setattr(self, name, copy.deepcopy(state[name]))


class ForeignNode(TreeNode):
    """A stock py_trees `behaviour`, wrapped as a node for its parent and its tree."""

    def __init__(self, behaviour: Behaviour) -> None:
        self.behaviour = behaviour
        self.name = self.path = behaviour.name
        self.registration = type(behaviour).__name__
        kind = NodeKind.CONTROL if behaviour.children else NodeKind.ACTION
        self.kind = kind  # type: ignore[misc]
        self.conditions = {}
        self._node_status = IDLE
        self._node_observers = ()
        self._node_runtime = None

    @property
    def child_nodes(self) -> list[TreeNode]:
        """The children as the tree sees them."""
        return [as_tree_node(child) for child in self.children]

    @property
    def children(self) -> list[Behaviour]:  # type: ignore[override]
        """The behaviour's children."""
        return self.behaviour.children

    @property
    def feedback_message(self) -> str:  # type: ignore[override]
        """The behaviour's feedback message."""
        return self.behaviour.feedback_message

    @property
    def status(self) -> Status:  # type: ignore[override]
        """The status that py_trees shows."""
        return self.behaviour.status

    @property
    def engine_status(self) -> NodeStatus:
        """The engine's status of the node."""
        parent: Any = self.behaviour.parent
        if isinstance(parent, TreeNode):
            return self._node_status
        return node_status(self.behaviour.status)

    def execute(self) -> NodeStatus:
        """Tick the behaviour as its parent; its INVALID counts as skipped."""
        runtime = self._node_runtime
        behaviour = self.behaviour
        visited = None if runtime is None else runtime.visited
        try:
            for node in behaviour.tick():
                if visited is not None and not isinstance(node, TreeNode):
                    visited.append(node)  # nodes of ours append themselves
        except NodeError:
            raise
        except Exception as error:
            raise NodeError(self.path, self.registration, str(error)) from error
        state = node_status(behaviour.status)
        if state is IDLE:
            return SKIPPED
        if state is FAILURE and runtime is not None and not behaviour.children:
            runtime.failed(self.path or self.name, behaviour.feedback_message)
        self._set_status(state)
        return state

    def halt(self) -> None:
        """Interrupt the behaviour."""
        if self._node_status is RUNNING:
            self.behaviour.stop(Status.INVALID)
        self._reset()


def as_tree_node(behaviour: Behaviour) -> Any:
    """Return a `TreeNode` unchanged, and wrap any other behaviour in a `ForeignNode`."""
    return behaviour if isinstance(behaviour, TreeNode) else ForeignNode(behaviour)


def behaviour_of(node: Any) -> Any:
    """Return the py_trees behaviour of a node: the node itself, or the wrapped one."""
    return node.behaviour if isinstance(node, ForeignNode) else node
