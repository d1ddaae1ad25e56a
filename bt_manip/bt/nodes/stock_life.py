"""How a node lives below parents, and in trees, of stock py_trees."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from py_trees.behaviour import Behaviour

from bt_manip.bt.status import FAILURE, RUNNING, SUCCESS, NodeStatus, Status

if TYPE_CHECKING:
    from bt_manip.bt.runtime import Runtime

_INVALID: Final = Status.INVALID


class StockLife(Behaviour):
    """The part of a node that stock py_trees calls, in terms of what the engine's nodes have."""

    _node_status: NodeStatus

    @property
    def runtime(self) -> "Runtime":
        """The surroundings that all nodes of the tree share."""
        raise NotImplementedError

    def execute(self) -> NodeStatus:
        """Tick the node and its children, and give the result."""
        raise NotImplementedError

    def halt(self) -> None:
        """Interrupt the node and what runs below it."""
        raise NotImplementedError

    def _reset(self) -> None:
        raise NotImplementedError

    def tick(self) -> Iterator[Behaviour]:
        """Tick the node for a stock py_trees parent or tree, and yield the nodes it ticked."""
        if self._node_status is SUCCESS or self._node_status is FAILURE:
            self._reset()
        runtime = self.runtime
        if runtime.visited is not None:  # a stock node between two of ours: the outer one reports
            self.execute()
            return
        if self.parent is None or not _below_node(self):
            runtime.fire_timers()
        visited: list[Behaviour] = []
        runtime.visited = visited
        runtime.observers.append(_ignore)
        try:
            self.execute()
        finally:
            runtime.visited = None
            runtime.observers.remove(_ignore)
        yield from visited

    def tick_once(self) -> None:
        """Tick the node for a stock py_trees parent or tree, without yielding."""
        if self._node_status is SUCCESS or self._node_status is FAILURE:
            self._reset()
        if self.parent is None or not _below_node(self):
            self.runtime.fire_timers()
        self.execute()

    def stop(self, new_status: Status) -> None:
        """Stop the node for a stock py_trees parent."""
        if new_status is _INVALID:
            if self._node_status is RUNNING:
                self.halt()
            self._reset()
        else:
            self.terminate(new_status)
        self.status = new_status

    def update(self) -> Any:
        """Not used by nodes that direct others."""
        return _INVALID


def _below_node(node: Behaviour) -> bool:
    parent = node.parent
    while parent is not None:
        if isinstance(parent, StockLife):
            return True
        parent = parent.parent
    return False


def _ignore(node: Any, old: Any, new: Any) -> None:
    """Observe nothing: only makes nodes report that they were ticked."""
