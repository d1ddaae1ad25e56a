"""What Sequence and Fallback have in common: children one after the other, until one decides."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Control
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus


class InOrder(Control):
    """Tick the children one after the other until one returns what ends it."""

    memory: ClassVar = ("_index", "_skipped")
    _goes_on: ClassVar[NodeStatus] = SUCCESS
    _ends: ClassVar[NodeStatus] = FAILURE
    _yields: ClassVar = False
    _index = 0
    _skipped = 0

    def _tick(self) -> NodeStatus:
        links = self._links_cache or self.links
        if self._node_status is not RUNNING:
            if self._node_status is IDLE:
                self._skipped = 0
            self._enter()
        index = self._index
        count = len(links)
        goes_on = self._goes_on
        yields = self._yields
        before = IDLE
        try:
            while index < count:
                link = links[index]
                if yields:
                    before = link._node_status
                state = link.execute()
                if state is goes_on:
                    index += 1
                    if yields and before is IDLE and index < count:
                        self.runtime.wake_up = True
                        return RUNNING
                elif state is RUNNING:
                    return RUNNING
                elif state is SKIPPED:
                    index += 1
                    self._skipped += 1
                else:
                    index = self._after_end(index)
                    return self._ends
            index = 0
        finally:
            self._index = index
        all_skipped = self._skipped == count
        self._skipped = 0
        self._reset_children()
        return SKIPPED if all_skipped else goes_on

    def _after_end(self, index: int) -> int:
        """Reset the children, and give the index of the child to start with next."""
        self._reset_children()
        return 0

    def _halt(self) -> None:
        self._index = 0
        self._skipped = 0
        super()._halt()
