"""A leaf that returns the status that a test sets, like the one of Nav2's unit tests."""

from bt_manip.bt import NodeStatus, SyncAction


class Dummy(SyncAction):
    """Return `result` at each tick."""

    result = NodeStatus.IDLE

    def _tick(self):
        return self.result
