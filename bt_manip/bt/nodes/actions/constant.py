"""AlwaysSuccess and AlwaysFailure."""

from typing import ClassVar

from bt_manip.bt.nodes.action import SyncAction
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus, Status
from bt_manip.bt.traits import SUCCEEDS, Traits

_SUCCESS = Status.SUCCESS


class AlwaysSuccess(SyncAction):
    """Succeed.

    | tick | SUCCESS |
    |------|---------|
    | halt | nothing |
    """

    traits: ClassVar = SUCCEEDS

    def execute(self) -> NodeStatus:
        """Succeed."""
        if self._node_guard is not None or self._node_observers:
            return Node.execute(self)
        self._node_status = SUCCESS
        self.status = _SUCCESS
        return SUCCESS

    def _tick(self) -> NodeStatus:
        return SUCCESS


class AlwaysFailure(SyncAction):
    """Fail.

    | tick | FAILURE |
    |------|---------|
    | halt | nothing |
    """

    traits: ClassVar = Traits(returns=frozenset({FAILURE}))

    def _tick(self) -> NodeStatus:
        self._because("always fails")
        return FAILURE
