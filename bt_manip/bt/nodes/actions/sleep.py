"""Sleep: wait for a time of the tree's clock."""

from collections.abc import Mapping
from typing import Any, ClassVar

from bt_manip.bt.nodes.action import Action
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.port_types import UNSIGNED
from bt_manip.bt.ports import Input
from bt_manip.bt.status import RUNNING, SUCCESS, Status
from bt_manip.bt.traits import Traits


class Timed(Node):
    """The part of a node with a timer that counts the tree's clock."""

    def get_state(self) -> dict[str, Any]:
        """Return the state, with the time that is left [s] where a timer runs."""
        deadline = self.runtime.timers.get(self)
        left = None if deadline is None else deadline - self.runtime.clock()
        return {**super().get_state(), "left": left}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state that `get_state` returned."""
        super().set_state(state)
        self.runtime.cancel_timer(self)
        if state["left"] is not None:
            self.runtime.start_timer(self, state["left"])


class Sleep(Timed, Action):
    """Wait.

    | tick | RUNNING until msec have passed, then SUCCESS; 0 is SUCCESS at once |
    |------|--------------------------------------------------------------------|
    | halt | the next round waits anew                                          |
    """

    memory: ClassVar = ("_waiting",)
    traits: ClassVar = Traits(returns=frozenset({SUCCESS, RUNNING}))
    msec = Input(UNSIGNED, doc="how long to wait [ms]")
    _waiting = False

    def initialise(self) -> None:
        """Start the timer."""
        milliseconds = self.msec
        self._waiting = milliseconds > 0
        if self._waiting:
            self.runtime.start_timer(self, milliseconds / 1000)

    def update(self) -> Status:
        """Check whether the time has passed."""
        return Status.RUNNING if self._waiting else Status.SUCCESS

    def on_timer(self) -> None:
        """Let the next tick succeed."""
        self._waiting = False
        self.runtime.wake_up = True

    def terminate(self, new_status: Status) -> None:
        """Cancel the timer."""
        self._waiting = False
        self.runtime.cancel_timer(self)
