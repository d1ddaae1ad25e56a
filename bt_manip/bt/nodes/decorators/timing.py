"""Delay and Timeout: the child after some time, or for some time at most."""

from typing import ClassVar

from bt_manip.bt.nodes.actions.sleep import Timed
from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.port_types import UNSIGNED
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, RUNNING, SUCCESS, NodeStatus


class _Started(Timed, Decorator):
    _started = False

    def _halt(self) -> None:
        self._started = False
        self.runtime.cancel_timer(self)
        super()._halt()


class Delay(_Started):
    """Wait, then tick the child.

    | child   | result                                           |
    |---------|--------------------------------------------------|
    | waiting | RUNNING until delay_msec have passed             |
    | SUCCESS | SUCCESS; the next round waits again              |
    | FAILURE | FAILURE; the next round waits again              |
    | RUNNING | RUNNING                                          |
    | SKIPPED | SKIPPED; the next round does not wait            |
    | halt    | the child is halted; the next round waits again  |
    """

    memory: ClassVar = ("_started", "_elapsed")
    delay_msec = Input(UNSIGNED, doc="how long to wait [ms]")
    _elapsed = False

    def _tick(self) -> NodeStatus:
        milliseconds: int = self.delay_msec
        if not self._started:
            self._started = True
            self._elapsed = False
            self._enter()
            self.runtime.start_timer(self, milliseconds / 1000)
        if not self._elapsed:
            return RUNNING
        state = self.child_node.execute()
        if state is SUCCESS or state is FAILURE:
            self._started = False
            self._reset_child()
        return state

    def on_timer(self) -> None:
        """Let the next tick reach the child."""
        self._elapsed = True
        self.runtime.wake_up = True


class Timeout(_Started):
    """Tick the child, and halt it when it has been running for too long.

    | child   | result                                                             |
    |---------|--------------------------------------------------------------------|
    | SUCCESS | SUCCESS                                                            |
    | FAILURE | FAILURE                                                            |
    | RUNNING | RUNNING; once msec have passed it is halted before the next tick,  |
    |         | which returns FAILURE                                              |
    | SKIPPED | SKIPPED, the time goes on                                          |
    | halt    | the child is halted                                                |

    0 milliseconds mean no limit.
    """

    memory: ClassVar = ("_started", "_child_halted")
    msec = Input(UNSIGNED, doc="how long the child may run [ms]; 0 for no limit")
    _child_halted = False

    def _tick(self) -> NodeStatus:
        milliseconds: int = self.msec
        if not self._started:
            self._started = True
            self._child_halted = False
            self._enter()
            if milliseconds > 0:
                self.runtime.start_timer(self, milliseconds / 1000)
        if self._child_halted:
            self._started = False
            self._because(f"{self.child_node.name} was still running after {milliseconds} ms")
            return FAILURE
        state = self.child_node.execute()
        if state is SUCCESS or state is FAILURE:
            self._started = False
            self.runtime.cancel_timer(self)
            self._reset_child()
        return state

    def on_timer(self) -> None:
        """Halt the child, if it still runs."""
        if self.child_node._node_status is RUNNING:
            self._child_halted = True
            self._reset_child()
            self.runtime.wake_up = True
