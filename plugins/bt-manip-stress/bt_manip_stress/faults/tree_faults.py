"""Faults of the tree: an exception, a delayed tick."""

from dataclasses import dataclass
from typing import Any, NoReturn

from bt_manip.bt import NodeKind, NodeStatus

from .fault import Fault, FaultError, parameter


@dataclass
class BehaviourException(Fault):
    """The node raises an exception at its next tick."""

    def begin(self) -> None:
        """Replace the node's ``update``."""
        behaviour: Any = getattr(self.context.node, "behaviour", self.context.node)
        if self.context.node.kind not in (NodeKind.ACTION, NodeKind.CONDITION):
            raise FaultError(f"'{behaviour.name}' is not a leaf")

        def update() -> NoReturn:
            raise RuntimeError("injected exception")

        behaviour.update = update
        self.at_end(delattr, behaviour, "update")


@dataclass
class TickDelay(Fault):
    """The tree is not ticked for some time, while arms and controllers continue."""

    duration: float = parameter(0.5, "Time without ticks [s].")

    def begin(self) -> None:
        """Replace the tree's ``tick``."""
        tree: Any = self.context.tree
        tree.tick = lambda: NodeStatus.RUNNING
        self.at_end(delattr, tree, "tick")
