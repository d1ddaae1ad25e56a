"""The runtime that all nodes of one tree share: clock, timers, wake-ups and observers."""

import time
from collections.abc import Callable
from operator import itemgetter
from typing import TYPE_CHECKING, Any

from bt_manip.exceptions import with_short_values

if TYPE_CHECKING:
    from bt_manip.bt.nodes.node import Node

Clock = Callable[[], float]
"""Returns the present time [s]."""

Observer = Callable[[Any, Any, Any], None]
"""Called with a node, its old and its new `NodeStatus`."""

_TOLERANCE = 1e-9  # [s]; a clock that adds up time steps may stay a rounding error below a deadline


class Runtime:
    """The surroundings of a running tree.

    Attributes:
        clock: Returns the present time [s].
        enums: Numbers that scripts and enumeration ports know by name.
        observers: Called on each change of a node's status.
        visited: While a py_trees generator drives the tree, the nodes ticked so far, else None.
        wake_up: Whether a node asked to be ticked again at once.
        timers: Deadlines [s] by node.
        reason: The node that failed last, and why: ``path: reason``, or an empty text.
    """

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self.clock = clock
        self.enums: dict[str, int] = {}
        self.observers: list[Observer] = []
        self.visited: list[Any] | None = None
        self.wake_up = False
        self.timers: dict[Node, float] = {}
        self.reason = ""

    def failed(self, path: str, reason: str) -> None:
        """Keep which node failed, and why."""
        self.reason = with_short_values(f"{path}: {reason or 'failed without a reason'}")

    def start_timer(self, node: "Node", duration: float) -> None:
        """Call the node's ``on_timer`` before the first tick after `duration` [s]."""
        self.timers.pop(node, None)
        self.timers[node] = self.clock() + duration

    def cancel_timer(self, node: "Node") -> None:
        """Forget the node's timer, if there is one."""
        self.timers.pop(node, None)

    def fire_timers(self) -> None:
        """Call the nodes whose time has come, the earliest deadline first."""
        now = self.clock() + _TOLERANCE
        due = [(deadline, node) for node, deadline in self.timers.items() if deadline <= now]
        for _, node in sorted(due, key=itemgetter(0)):
            if self.timers.pop(node, None) is not None:
                node.on_timer()
