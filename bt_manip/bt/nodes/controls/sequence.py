"""Sequence, Fallback and their variants: children one after the other, until one decides."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Control
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus


class InOrder(Control):
    """Tick the children one after the other until one returns the ending status."""

    memory: ClassVar = ("_index", "_skipped")
    _goes_on: ClassVar[NodeStatus] = SUCCESS
    _ends: ClassVar[NodeStatus] = FAILURE
    _yields: ClassVar = False
    _index = 0
    _skipped = 0

    def _tick(self) -> NodeStatus:
        children = self._child_nodes or self.child_nodes
        if self._node_status is not RUNNING:
            if self._node_status is IDLE:
                self._skipped = 0
            self._enter()
        index = self._index
        count = len(children)
        goes_on = self._goes_on
        yields = self._yields
        before = IDLE
        try:
            while index < count:
                child = children[index]
                if yields:
                    before = child._node_status
                state = child.execute()
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


class Sequence(InOrder):
    """Tick the children one after the other; fail as soon as one fails.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | the next child is ticked; after the last one SUCCESS                |
    | FAILURE | all are reset, FAILURE; the next round starts with the first child  |
    | RUNNING | RUNNING; the next tick goes on with this child                      |
    | SKIPPED | as SUCCESS; SKIPPED if all were skipped                             |
    | halt    | the running child is halted, the next round starts with the first   |
    """


class AsyncSequence(Sequence):
    """A Sequence that pauses after each child that succeeded within one tick.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | in its first tick, and others remain: RUNNING, and the tree is      |
    |         | woken up to go on; else as Sequence                                 |
    | else    | FAILURE, RUNNING, SKIPPED and halt: as Sequence                     |
    """

    _yields = True


class SequenceWithMemory(Sequence):
    """A Sequence that goes on with the child that failed, not with the first one.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | as AsyncSequence                                                    |
    | FAILURE | this and the later children are halted, FAILURE; the next round     |
    |         | starts with this child                                              |
    | RUNNING | as Sequence                                                         |
    | SKIPPED | as Sequence                                                         |
    | halt    | the children are halted, the next round goes on with the same child |
    """

    _yields = True

    def _after_end(self, index: int) -> int:
        for later in range(index, len(self.child_nodes)):
            self._halt_child(later)
        return index

    def _halt(self) -> None:
        Control._halt(self)


class Fallback(InOrder):
    """Tick the children one after the other; succeed as soon as one succeeds.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | all are reset, SUCCESS                                              |
    | FAILURE | the next child is ticked; after the last one FAILURE                |
    | RUNNING | RUNNING; the next tick goes on with this child                      |
    | SKIPPED | as FAILURE; SKIPPED if all were skipped                             |
    | halt    | the running child is halted, the next round starts with the first   |
    """

    _goes_on = FAILURE
    _ends = SUCCESS


class AsyncFallback(Fallback):
    """A Fallback that pauses after each child that failed within one tick.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | FAILURE | in its first tick, and others remain: RUNNING, and the tree is      |
    |         | woken up to go on; else as Fallback                                 |
    | else    | SUCCESS, RUNNING, SKIPPED and halt: as Fallback                     |
    """

    _yields = True
