"""Repeat and RetryUntilSuccessful: the child several times."""

from typing import ClassVar

from bt_manip.bt.nodes.decorator import Decorator
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SUCCESS, NodeStatus
from bt_manip.exceptions import PortError


class Repeat(Decorator):
    """Tick the child until it has succeeded a number of times.

    | child   | what happens                                                         |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | counted; SUCCESS after num_cycles. Else it starts anew: in this tick |
    |         | if it had been running, else RUNNING and the tree is woken up        |
    | FAILURE | FAILURE, the count starts anew                                       |
    | RUNNING | RUNNING                                                              |
    | SKIPPED | SKIPPED, the count stays                                             |
    | halt    | the child is halted, the count starts anew                           |

    -1 cycles never end, 0 cycles succeed without a tick of the child.
    """

    memory: ClassVar = ("_count",)
    num_cycles = Input(
        int,
        doc="how many successes; -1 for no end",
    )
    _count = 0

    def _tick(self) -> NodeStatus:
        cycles: int = self.num_cycles
        more = cycles == -1 or self._count < cycles
        self._enter()
        link = self.link
        while more:
            before = link._node_status
            state = link.execute()
            if state is SUCCESS:
                self._count += 1
                more = cycles == -1 or self._count < cycles
                self._reset_child()
                if more and before is IDLE:
                    self.runtime.wake_up = True
                    return RUNNING
            elif state is RUNNING:
                return RUNNING
            elif state is FAILURE:
                self._count = 0
                self._reset_child()
                return FAILURE
            else:
                self._reset_child()
                return state
        self._count = 0
        return SUCCESS

    def _halt(self) -> None:
        self._count = 0
        super()._halt()


class RetryUntilSuccessful(Decorator):
    """Tick the child until it succeeds, a number of times at the most.

    | child   | what happens                                                         |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | SUCCESS, the count starts anew                                       |
    | FAILURE | counted; FAILURE after num_attempts, which is read again each time.  |
    |         | Else it starts anew: in this tick if it had been running, else       |
    |         | RUNNING and the tree is woken up                                     |
    | RUNNING | RUNNING                                                              |
    | SKIPPED | SKIPPED, the count stays                                             |
    | halt    | the child is halted, the count starts anew                           |

    -1 attempts never end, 0 attempts fail without a tick of the child.
    """

    memory: ClassVar = ("_count",)
    num_attempts = Input(
        int,
        doc="how many attempts; -1 for no end",
    )
    _count = 0

    def _tick(self) -> NodeStatus:
        attempts: int = self.num_attempts
        more = attempts == -1 or self._count < attempts
        self._enter()
        link = self.link
        while more:
            before = link._node_status
            state = link.execute()
            if state is FAILURE:
                self._count += 1
                try:
                    attempts = self.num_attempts
                except PortError:
                    pass  # it was there at the start of the tick: go on with what it said then
                more = attempts == -1 or self._count < attempts
                self._reset_child()
                if more and before is IDLE:
                    self.runtime.wake_up = True
                    return RUNNING
            elif state is RUNNING:
                return RUNNING
            elif state is SUCCESS:
                self._count = 0
                self._reset_child()
                return SUCCESS
            else:
                self._reset_child()
                return state
        self._count = 0
        if attempts == 0:
            self._because("no attempts are allowed")
        return FAILURE

    def _halt(self) -> None:
        self._count = 0
        super()._halt()
