"""Samples that nodes drew, and nodes that were retried or rescued, in a cycle."""

from collections import Counter
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.bt import AsyncFallback, Fallback, ReactiveFallback, RetryUntilSuccessful
from bt_manip.bt.nodes import NodeKind, behaviour_of

_FALLBACKS = (Fallback, AsyncFallback, ReactiveFallback)
_AXES = ("x", "y", "z", "rx", "ry", "rz")


class NodeLog:
    """Tree observer that keeps drawn outputs, and counts retries and rescues.

    A retry is a child of `RetryUntilSuccessful` that starts again after its failure. A fallback
    rescues where a child succeeds after an earlier one failed because of an action: because it
    failed, or was halted, last of all leaves. A failed condition is a choice, not a failure.

    Attributes:
        drawn: Values of the outputs that nodes declare as `drawn`, of the last time each succeeded,
            by path and port.
        retries: Numbers of retries, by path of the `RetryUntilSuccessful`.
        rescues: Numbers of rescues, by path of the fallback.
    """

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Begin a cycle."""
        self.drawn: dict[str, dict[str, Any]] = {}
        self.retries: Counter[str] = Counter()
        self.rescues: Counter[str] = Counter()
        self._failed: dict[Any, int] = {}  # by parent: index of the first child that failed
        self._action_failed = False

    def __call__(self, node: Any, old: Any, new: Any) -> None:
        """Record a change of a node's status."""
        if new.name == "SUCCESS" and node.drawn:
            self.drawn[node.path] = {k: _plain(v) for k, v in node._node_drawn.items()}
        if node.kind in (NodeKind.ACTION, NodeKind.CONDITION):
            halted = new.name == "IDLE" and old.name == "RUNNING"
            if new.name == "FAILURE" or halted:
                self._action_failed = node.kind is NodeKind.ACTION
        elif new.name != "RUNNING":
            self._failed.pop(node, None)  # its round is over
        behaviour = behaviour_of(node)
        parent = behaviour.parent
        if isinstance(parent, RetryUntilSuccessful):
            self._child_of_retry(parent, old, new)
        elif isinstance(parent, _FALLBACKS):
            self._child_of_fallback(parent, behaviour, new)

    def _child_of_retry(self, parent: Any, old: Any, new: Any) -> None:
        if old.name == "IDLE" and self._failed.pop(parent, None) is not None:
            self.retries[parent.path] += 1
        if new.name == "FAILURE":
            self._failed[parent] = 0

    def _child_of_fallback(self, parent: Any, child: Any, new: Any) -> None:
        index = parent.children.index(child)
        if new.name == "FAILURE" and self._action_failed:
            self._failed.setdefault(parent, index)
        elif new.name == "SUCCESS" and self._failed.get(parent, index) < index:
            self.rescues[parent.path] += 1


def _plain(value: Any) -> Any:
    """Convert a value to types of JSON, a pose to position [m] and rotation vector [rad]."""
    if isinstance(value, pin.SE3):
        numbers = (*value.translation, *pin.log3(value.rotation))
        return {axis: float(n) + 0.0 for axis, n in zip(_AXES, numbers, strict=True)}  # no -0.0
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(one) for one in value]
    if isinstance(value, np.generic):
        return value.item()
    return value if isinstance(value, str | int | float) else str(value)
