"""The status of a node: the engine's five values and their py_trees counterparts."""

from enum import IntEnum
from typing import Final

from py_trees.common import Status as Status

from bt_manip.exceptions import TreeError


class NodeStatus(IntEnum):
    """The status of a node, with the numbers that BehaviorTree.CPP and Groot2 use.

    ``IDLE`` corresponds to py_trees' ``INVALID``. ``SKIPPED`` is only ever returned by a tick; it
    is never kept as the status of a node.
    """

    IDLE = 0
    RUNNING = 1
    SUCCESS = 2
    FAILURE = 3
    SKIPPED = 4

    def __str__(self) -> str:
        """Return the name; an ``IntEnum`` of its own would print its number."""
        return self.name

    def __format__(self, spec: str) -> str:
        """Format the name."""
        return format(self.name, spec)


IDLE: Final = NodeStatus.IDLE
RUNNING: Final = NodeStatus.RUNNING
SUCCESS: Final = NodeStatus.SUCCESS
FAILURE: Final = NodeStatus.FAILURE
SKIPPED: Final = NodeStatus.SKIPPED

_STATUSES: Final = tuple(NodeStatus)

PY_STATUS: Final = (
    Status.INVALID,
    Status.RUNNING,
    Status.SUCCESS,
    Status.FAILURE,
    Status.INVALID,
)
"""py_trees' status of each `NodeStatus`, by its number."""


def node_status(status: Status | NodeStatus) -> NodeStatus:
    """Convert the result of an ``update`` to the engine's status; ``INVALID`` becomes ``IDLE``.

    Raises:
        TreeError: If it is not a status.
    """
    if isinstance(status, NodeStatus):
        return status
    if isinstance(status, Status):
        return _STATUSES[PY_STATUS.index(status)]
    raise TreeError(f"update() returned {status!r}; expected a Status")
