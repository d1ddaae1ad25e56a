"""Repeat and RetryUntilSuccessful: the child several times."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus
from bt_manip.exceptions import PortError


class _Counting(Decorator):
    """Tick the child again each time it returns the counted status, up to a limit."""

    memory: ClassVar = ("_count",)
    _counted: ClassVar[NodeStatus] = SUCCESS
    _count = 0

    def _most(self) -> int:
        """Read how many are enough; -1 for no end."""
        raise NotImplementedError

    def _most_now(self, most: int) -> int:
        """Return how many are enough after one more was counted."""
        return most

    def _tick(self) -> NodeStatus:
        most = self._most()
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
            most = self._most_now(most)
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


class Repeat(_Counting):
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

    num_cycles = Input(int, doc="how many successes; -1 for no end")

    def _most(self) -> int:
        return self.num_cycles


class RetryUntilSuccessful(_Counting):
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

    num_attempts = Input(int, doc="how many attempts; -1 for no end")
    _counted = FAILURE

    def _most(self) -> int:
        attempts = self.num_attempts
        if attempts == 0:
            self._because("no attempts are allowed")
        return attempts

    def _most_now(self, most: int) -> int:
        try:
            return self._most()
        except PortError:
            return most  # it was there at the start of the tick: go on with the value of then
