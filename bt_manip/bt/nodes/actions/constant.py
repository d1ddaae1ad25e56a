"""AlwaysSuccess and AlwaysFailure."""

from typing import ClassVar

from bt_manip.bt.nodes.action import SyncAction
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus
from bt_manip.bt.traits import SUCCEEDS, Traits


class AlwaysSuccess(SyncAction):
    """Succeed.

    | tick | SUCCESS |
    |------|---------|
    | halt | nothing |
    """

    traits: ClassVar = SUCCEEDS

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
