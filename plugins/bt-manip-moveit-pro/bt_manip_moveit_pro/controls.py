"""Decorators of MoveIt Pro."""

import math
from typing import Any, ClassVar

from bt_manip.bt import Decorator, Input, NodeStatus, Output, Repeat

FAILURE, IDLE, RUNNING = NodeStatus.FAILURE, NodeStatus.IDLE, NodeStatus.RUNNING
SKIPPED, SUCCESS = NodeStatus.SKIPPED, NodeStatus.SUCCESS


class ForEach(Decorator):
    """Tick the child once for each item of a list, and hand the item and its index to it.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | empty   | SUCCESS; the child is not ticked                                    |
    | SUCCESS | the next tick takes the next item; SUCCESS after the last one       |
    | FAILURE | FAILURE                                                             |
    | RUNNING | RUNNING; the next tick goes on with this item                       |
    | SKIPPED | as SUCCESS                                                          |
    | halt    | the child is halted; the next round starts with the first item      |
    """

    memory: ClassVar = ("_position",)
    _ends_with: ClassVar[NodeStatus] = FAILURE
    _at_the_end: ClassVar[NodeStatus] = SUCCESS
    vector_in = Input(doc="the items: a list, or a text such as 1;2;3")
    out = Output(doc="the item that the child works on")
    index = Output(int, doc="its index, from 0")
    _position = 0

    def _tick(self) -> NodeStatus:
        items: Any = self.read_port("vector_in")
        if isinstance(items, str):
            items = items.removesuffix(";").split(";") if items else []
        if self._node_status is IDLE:
            self._position = 0
        if self._position < len(items):
            if self.child_node.engine_status is not RUNNING:
                self.out, self.index = items[self._position], self._position
            self._enter()
            state = self.child_node.execute()
            if state is RUNNING:
                return RUNNING
            self._reset_child()
            if state is self._ends_with:
                return state
            self._position += 1
            if self._position < len(items):
                return RUNNING
        if self._at_the_end is FAILURE:
            self._because("the child succeeded with none of the items")
        return self._at_the_end


class ForEachUntilSuccess(ForEach):
    """Tick the child with one item of a list after another, until it succeeds.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | empty   | FAILURE; the child is not ticked                                    |
    | SUCCESS | SUCCESS; `out` and `index` stay those of this item                  |
    | FAILURE | the next tick takes the next item; FAILURE after the last one       |
    | RUNNING | RUNNING; the next tick goes on with this item                       |
    | SKIPPED | as FAILURE                                                          |
    | halt    | the child is halted; the next round starts with the first item      |
    """

    _ends_with: ClassVar = SUCCESS
    _at_the_end: ClassVar = FAILURE


class RepeatUnlessFailureEachTick(Decorator):
    """Tick the child until it has succeeded a number of times, once per tick.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | counted; SUCCESS after num_cycles, else RUNNING                     |
    | FAILURE | FAILURE, the count starts anew                                      |
    | RUNNING | RUNNING                                                             |
    | SKIPPED | SKIPPED, the count stays                                            |
    | halt    | the child is halted, the count starts anew                          |

    -1 cycles never end, 0 cycles succeed without a tick of the child.
    """

    memory: ClassVar = ("_count",)
    num_cycles = Input(int, default=-1, doc="how many successes; -1 for no end")
    _count = 0

    def _tick(self) -> NodeStatus:
        if self._node_status is IDLE:
            self._count = 0
        most = math.inf if self.num_cycles == -1 else self.num_cycles
        if self._count < most:
            self._enter()
            state = self.child_node.execute()
            if state is RUNNING:
                return RUNNING
            self._reset_child()
            if state is FAILURE or state is SKIPPED:
                return state
            self._count += 1
        return SUCCESS if self._count >= most else RUNNING


class RepeatUnlessFailureWithinTick(Repeat):
    """Do as Repeat: tick the child again in the same tick, a number of times."""
