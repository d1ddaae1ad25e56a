"""Stock py_trees behaviours among the nodes of a tree."""

from typing import Any

from py_trees.behaviour import Behaviour

from bt_manip.bt.nodes.names import NodeKind
from bt_manip.bt.nodes.stock_life import StockLife
from bt_manip.bt.status import IDLE, RUNNING, SKIPPED, NodeStatus, Status, node_status
from bt_manip.exceptions import NodeError


class ForeignNode:
    """Makes a stock py_trees behaviour look like a node of ours to its parent and to the tree.

    Attributes:
        behaviour: The py_trees behaviour.
    """

    ports: dict[str, Any] = {}
    memory: tuple[str, ...] = ()
    orphans: tuple[Behaviour, ...] = ()

    def __init__(self, behaviour: Behaviour) -> None:
        """Wrap a behaviour."""
        self.behaviour = behaviour
        self.name = behaviour.name
        self.registration = type(behaviour).__name__
        self.kind = NodeKind.CONTROL if behaviour.children else NodeKind.ACTION
        self.path = behaviour.name
        self.uid = 0
        self.conditions: dict[str, str] = {}
        self.attributes: dict[str, str] = {}
        self.given: dict[str, Any] = {}
        self._node_status = IDLE
        self._node_observers: Any = ()
        self._node_runtime: Any = None

    @property
    def children(self) -> list[Behaviour]:
        """The behaviour's children."""
        return self.behaviour.children

    @property
    def links(self) -> list[Any]:
        """The children as the tree sees them."""
        return [as_link(child) for child in self.children]

    @property
    def feedback_message(self) -> str:
        """What the behaviour says about itself."""
        return self.behaviour.feedback_message

    @property
    def status(self) -> Status:
        """What py_trees shows."""
        return self.behaviour.status

    @property
    def engine_status(self) -> NodeStatus:
        """The engine's status of the node."""
        if isinstance(self.behaviour.parent, StockLife):
            return self._node_status
        return node_status(self.behaviour.status)

    def execute(self) -> NodeStatus:
        """Tick the behaviour as its parent; its INVALID counts as skipped."""
        runtime = self._node_runtime
        visited = None if runtime is None else runtime.visited
        try:
            if visited is None:
                self.behaviour.tick_once()
            else:
                for node in self.behaviour.tick():
                    if not isinstance(node, StockLife):  # ours enter themselves
                        visited.append(node)
        except NodeError:
            raise
        except Exception as error:
            raise NodeError(self.path, self.registration, str(error)) from error
        state = node_status(self.behaviour.status)
        if state is IDLE:
            return SKIPPED
        if state is NodeStatus.FAILURE and runtime is not None and not self.behaviour.children:
            runtime.reason = (self, self.behaviour.feedback_message)
        self._set_status(state)
        return state

    def halt(self) -> None:
        """Interrupt the behaviour."""
        if self._node_status is RUNNING:
            self.behaviour.stop(Status.INVALID)
        self._reset()

    def _reset(self) -> None:
        self._set_status(IDLE)

    def _set_status(self, new: NodeStatus) -> None:
        old = self._node_status
        if old is not new:
            self._node_status = new
            for observer in self._node_observers:
                observer(self, old, new)

    def get_state(self) -> dict[str, Any]:
        """Give nothing: a stock behaviour has no state that could be given."""
        return {}

    def set_state(self, state: Any) -> None:
        """Take back nothing."""


def as_link(behaviour: Behaviour) -> Any:
    """Give a behaviour as a tree sees it: a node of ours, or a `ForeignNode` around it."""
    return behaviour if isinstance(behaviour, StockLife) else ForeignNode(behaviour)
