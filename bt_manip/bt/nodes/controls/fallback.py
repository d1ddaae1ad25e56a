"""Fallback and its kin: children one after the other, until one succeeds."""

from bt_manip.bt.nodes.controls.in_order import InOrder
from bt_manip.bt.status import FAILURE, SUCCESS


class Fallback(InOrder):
    """Tick the children one after the other; succeed as soon as one succeeds.

    | child   | what happens                                                        |
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
