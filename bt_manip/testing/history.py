"""What the nodes of a tree went through, tick by tick."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bt_manip.bt import NodeStatus, Tree


class StatusChange(NamedTuple):
    """One node's change of status."""

    tick: int  # from 1
    time: float  # [s] simulated
    node: Any
    status: NodeStatus
    message: str  # what the node said about itself then


@dataclass
class History:
    """Notes every change of status in a tree; it is one of the tree's observers.

    Attributes:
        tree: The tree.
        tick: How often the tree has been ticked.
        changes: All changes, returns to idle left out, in order.
    """

    tree: Tree
    tick: int = 0
    changes: list[StatusChange] = field(default_factory=list)

    def __call__(self, node: Any, old: NodeStatus, new: NodeStatus) -> None:
        """Note a change."""
        if new is not NodeStatus.IDLE:
            message = str(node.feedback_message)
            self.changes.append(StatusChange(self.tick, self.tree.clock(), node, new, message))

    def last(self, node: Any) -> StatusChange | None:
        """Return the last change of a node, or None when it was never ticked."""
        return next((change for change in reversed(self.changes) if change.node is node), None)

    def ended(self, node: Any) -> list[NodeStatus]:
        """List how a node ended, each time it did."""
        return [
            change.status
            for change in self.changes
            if change.node is node and change.status is not NodeStatus.RUNNING
        ]

    def ticked(self, node: Any) -> bool:
        """Return whether a node was ever ticked."""
        return any(change.node is node for change in self.changes)
