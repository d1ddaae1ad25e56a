"""A leaf that returns the status that a test sets, like the one of Nav2's unit tests."""

from bt_manip.bt import NodeStatus, SyncAction

IDLE, RUNNING, SUCCESS = NodeStatus.IDLE, NodeStatus.RUNNING, NodeStatus.SUCCESS
FAILURE, SKIPPED = NodeStatus.FAILURE, NodeStatus.SKIPPED


class Dummy(SyncAction):
    """Return `result` at each tick, or the next of several."""

    result = NodeStatus.IDLE

    def _tick(self):
        return self.result if isinstance(self.result, NodeStatus) else next(self.result)
