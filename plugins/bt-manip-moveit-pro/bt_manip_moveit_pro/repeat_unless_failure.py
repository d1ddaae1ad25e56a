"""RepeatUnlessFailureEachTick and RepeatUnlessFailureWithinTick of MoveIt Pro."""

from typing import ClassVar

from bt_manip.bt import Decorator, Input, NodeStatus, Repeat

FAILURE, IDLE, RUNNING = NodeStatus.FAILURE, NodeStatus.IDLE, NodeStatus.RUNNING
SKIPPED, SUCCESS = NodeStatus.SKIPPED, NodeStatus.SUCCESS


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
        most = self.num_cycles
        if most != -1 and self._count >= most:
            return SUCCESS
        self._enter()
        state = self.child_node.execute()
        if state is RUNNING:
            return RUNNING
        self._reset_child()
        if state is FAILURE or state is SKIPPED:
            return state
        self._count += 1
        return SUCCESS if most != -1 and self._count >= most else RUNNING

    def _halt(self) -> None:
        self._count = 0
        super()._halt()


class RepeatUnlessFailureWithinTick(Repeat):
    """Do as Repeat: tick the child again in the same tick, a number of times."""
