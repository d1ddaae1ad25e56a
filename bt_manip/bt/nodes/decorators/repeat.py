"""Repeat and RetryUntilSuccessful: the child several times."""

from contextlib import suppress
from typing import ClassVar

from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus
from bt_manip.exceptions import PortError


class Counting(Decorator):
    """Tick the child again each time it returns the counted status, up to a limit."""

    memory: ClassVar = ("_count",)
    port: ClassVar[str]
    _counted: ClassVar[NodeStatus] = SUCCESS
    _count = 0

    def _tick(self) -> NodeStatus:
        most = self.read_port(self.port)
        if most == 0 and self._counted is FAILURE:
            self._because("no attempts are allowed")
        more = most == -1 or self._count < most
        self._enter()
        child = self.child_node
        while more:
            before = child._node_status
            state = child.execute()
            if state is RUNNING:
                return RUNNING
            if state is not self._counted:
                if state is not SKIPPED:
                    self._count = 0
                self._reset_child()
                return state
            self._count += 1
            if self._counted is FAILURE:
                with suppress(PortError):  # unset by the child: the limit from before holds
                    most = self.read_port(self.port)
            more = most == -1 or self._count < most
            self._reset_child()
            if more and before is IDLE:
                self.runtime.wake_up = True
                return RUNNING
        self._count = 0
        return self._counted

    def _halt(self) -> None:
        self._count = 0
        super()._halt()


class Repeat(Counting):
    """Tick the child until it has succeeded a number of times.

    | child   | result                                                               |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | counted; SUCCESS after num_cycles. Else it starts anew: in this tick |
    |         | if it had been running, else RUNNING and the tree is woken up        |
    | FAILURE | FAILURE, the count starts anew                                       |
    | RUNNING | RUNNING                                                              |
    | SKIPPED | SKIPPED, the count stays                                             |
    | halt    | the child is halted, the count starts anew                           |

    -1 cycles never end, 0 cycles succeed without a tick of the child.
    """

    port = "num_cycles"
    num_cycles = Input(int, doc="how many successes; -1 for no end")


class RetryUntilSuccessful(Counting):
    """Tick the child until it succeeds, a number of times at most.

    | child   | result                                                               |
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

    port = "num_attempts"
    num_attempts = Input(int, doc="how many attempts; -1 for no end")
    _counted = FAILURE
