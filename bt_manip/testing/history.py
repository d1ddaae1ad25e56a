"""Recorded status changes of the nodes of a tree."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bt_manip.bt import NodeStatus, Tree


class StatusChange(NamedTuple):
    """One node's change of status."""

    tick: int  # from 1
    time: float  # [s] simulated
    node: Any
    status: NodeStatus
    message: str  # feedback message


@dataclass
class History:
    """Tree observer that records every change of status.

    Attributes:
        tree: The tree.
        tick: Number of ticks so far.
        changes: All changes in order, except returns to idle.
    """

    tree: Tree
    tick: int = 0
    changes: list[StatusChange] = field(default_factory=list)

    def __call__(self, node: Any, old: NodeStatus, new: NodeStatus) -> None:
        """Record a change."""
        if new is not NodeStatus.IDLE:
            message = str(node.feedback_message)
            self.changes.append(StatusChange(self.tick, self.tree.clock(), node, new, message))

    def last(self, node: Any) -> StatusChange | None:
        """Return the last change of a node, or None when it was never ticked."""
        return next((change for change in reversed(self.changes) if change.node is node), None)

    def ended(self, node: Any) -> list[NodeStatus]:
        """Return the results of a node, in order."""
        return [
            change.status
            for change in self.changes
            if change.node is node and change.status is not NodeStatus.RUNNING
        ]

    def ticked(self, node: Any) -> bool:
        """Return whether a node was ever ticked."""
        return any(change.node is node for change in self.changes)
