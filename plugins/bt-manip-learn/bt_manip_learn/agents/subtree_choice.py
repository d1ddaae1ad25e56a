"""Actions that select parts of the tree."""

from typing import Any

import numpy as np

from bt_manip.behaviours import ArmBehaviour
from bt_manip.bt import NodeKind, NodeStatus
from bt_manip.exceptions import BtManipError, NodeError

from .actions import ActionKind, ActionSpace
from .episodes import Episodes


class SubtreeChoice(ActionKind):
    """The part of the tree to tick during the step: a sub-tree, or a leaf that uses a robot.

    0 selects none and halts the running part. A part that is selected again continues, or restarts
    if it has completed.

    Attributes:
        status: Status of the selected part after the last step.
    """

    kind = "subtree_choice"

    def __init__(self, episodes: Episodes) -> None:
        super().__init__(episodes)
        self._nodes = [
            node
            for node in episodes.run.tree.nodes[1:]
            if isinstance(node, ArmBehaviour) or node.kind is NodeKind.SUBTREE
        ]
        self._running: Any = None
        self.status = NodeStatus.IDLE
        choices = ("", *(node.path for node in self._nodes))
        low, high = np.array([0.0]), np.array([len(choices) - 1.0])
        self.space = ActionSpace(low, high, ("choice",), ("-",), choices)

    def command(self, action: Any) -> None:
        """Select a part; see `ActionKind.step`."""
        number = int(action)
        if not 0 <= number < len(self.space.choices):
            raise BtManipError(
                f"a choice is a number from 0 to {len(self.space.choices) - 1}, got {action}"
            )
        self._episodes.release()
        node = self._nodes[number - 1] if number else None
        if self._running is not None and self._running is not node:
            self._running.halt()
        self._running, self.status = node, NodeStatus.IDLE

    def tick(self) -> NodeStatus:
        """Tick the selected part."""
        if self._running is not None:
            try:
                self.status = self._episodes.run.tree.tick(self._running)
            except NodeError as error:
                if not isinstance(error.__cause__, BtManipError):
                    raise
                self._running.halt()
                self.status = NodeStatus.FAILURE  # e.g. an input is not written yet
            if self.status is not NodeStatus.RUNNING:
                self._running = None
        return NodeStatus.RUNNING

    def get_state(self) -> Any:
        """Return the running part and its status as plain data."""
        number = 0 if self._running is None else 1 + self._nodes.index(self._running)
        return {"running": number, "status": self.status.name}

    def set_state(self, state: Any) -> None:
        """Restore a state of `get_state`."""
        self._running = self._nodes[state["running"] - 1] if state["running"] else None
        self.status = NodeStatus[state["status"]]

    def recorded(self) -> np.ndarray:
        """Return the innermost running part."""
        running = [i for i, n in enumerate(self._nodes, 1) if n.engine_status is NodeStatus.RUNNING]
        return np.array(running[-1] if running else 0, dtype=np.int64)
