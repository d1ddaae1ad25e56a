"""Sequence and its two kin: children one after the other, until one fails."""

from bt_manip.bt.nodes.controls.in_order import InOrder
from bt_manip.bt.nodes.parent import Control


class Sequence(InOrder):
    """Tick the children one after the other; fail as soon as one fails.

    | child   | what happens                                                        |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | the next child is ticked; after the last one SUCCESS                |
    | FAILURE | all are reset, FAILURE; the next round starts with the first child  |
    | RUNNING | RUNNING; the next tick goes on with this child                      |
    | SKIPPED | as SUCCESS; SKIPPED if all were skipped                             |
    | halt    | the running child is halted, the next round starts with the first   |
    """


class AsyncSequence(Sequence):
    """A Sequence that pauses after each child that succeeded within one tick.

    | child   | what happens                                                        |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | in its first tick, and others remain: RUNNING, and the tree is      |
    |         | woken up to go on; else as Sequence                                 |
    | FAILURE | as Sequence                                                         |
    | RUNNING | as Sequence                                                         |
    | SKIPPED | as Sequence                                                         |
    | halt    | as Sequence                                                         |
    """

    _yields = True


class SequenceWithMemory(Sequence):
    """A Sequence that goes on with the child that failed, not with the first one.

    | child   | what happens                                                        |
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
        for later in range(index, len(self.links)):
            self._halt_child(later)
        return index

    def _halt(self) -> None:
        Control._halt(self)
