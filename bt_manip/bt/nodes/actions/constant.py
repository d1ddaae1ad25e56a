"""AlwaysSuccess and AlwaysFailure."""

from bt_manip.bt.nodes.action import SyncAction
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus


class AlwaysSuccess(SyncAction):
    """Succeed.

    | tick | SUCCESS |
    |------|---------|
    | halt | nothing |
    """

    def _tick(self) -> NodeStatus:
        return SUCCESS


class AlwaysFailure(SyncAction):
    """Fail.

    | tick | FAILURE |
    |------|---------|
    | halt | nothing |
    """

    def _tick(self) -> NodeStatus:
        self._because("always fails")
        return FAILURE
