"""Fallback and its kin: children one after the other, until one succeeds."""

from typing import ClassVar

from bt_manip.bt.nodes.control import Control
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus


class Fallback(Control):
    """Tick the children one after the other; succeed as soon as one succeeds.

    | child   | what happens                                                        |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | all are reset, SUCCESS                                              |
    | FAILURE | the next child is ticked; after the last one FAILURE                |
    | RUNNING | RUNNING; the next tick goes on with this child                      |
    | SKIPPED | as FAILURE; SKIPPED if all were skipped                             |
    | halt    | the running child is halted, the next round starts with the first   |
    """

    memory: ClassVar = ("_index", "_skipped")
    _yields = False
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
        yields = self._yields
        before = IDLE
        try:
            while index < count:
                link = links[index]
                if yields:
                    before = link._node_status
                state = link.execute()
                if state is FAILURE:
                    index += 1
                    if yields and before is IDLE and index < count:
                        self.runtime.wake_up = True
                        return RUNNING
                elif state is RUNNING:
                    return RUNNING
                elif state is SUCCESS:
                    self._reset_children()
                    index = 0
                    return SUCCESS
                else:
                    index += 1
                    self._skipped += 1
            index = 0
        finally:
            self._index = index
        all_skipped = self._skipped == count
        self._skipped = 0
        self._reset_children()
        return SKIPPED if all_skipped else FAILURE

    def _halt(self) -> None:
        self._index = 0
        self._skipped = 0
        super()._halt()


class AsyncFallback(Fallback):
    """A Fallback that pauses after each child that failed within one tick.

    | child   | what happens                                                        |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | as Fallback                                                         |
    | FAILURE | in its first tick, and others remain: RUNNING, and the tree is      |
    |         | woken up to go on; else as Fallback                                 |
    | RUNNING | as Fallback                                                         |
    | SKIPPED | as Fallback                                                         |
    | halt    | as Fallback                                                         |
    """

    _yields = True
