"""The scripts around the tick of a node: pre- and post-conditions."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from bt_manip.bt.script.evaluation import Environment, is_true
from bt_manip.bt.script.parser import ParsedScript
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus

if TYPE_CHECKING:
    from bt_manip.bt.nodes.node import Node

CONDITIONS: Final = MappingProxyType(
    {
        "failure_if": "_failureIf",
        "success_if": "_successIf",
        "skip_if": "_skipIf",
        "while_true": "_while",
        "on_success": "_onSuccess",
        "on_failure": "_onFailure",
        "post": "_post",
        "on_halted": "_onHalted",
    }
)
"""The scripts around a tick: their keyword in Python and their attribute in a document."""

PreTick = Callable[["Node"], NodeStatus | None]
PostTick = Callable[["Node", NodeStatus], NodeStatus | None]

GUARDS: Final = {
    "_failureIf": (FAILURE, True),
    "_successIf": (SUCCESS, True),
    "_skipIf": (SKIPPED, True),
    "_while": (SKIPPED, False),
}
"""Scripts in front of a tick: the status in its place, and the truth with which they give it."""


class Guard:
    """Decides before a tick whether the node is ticked, and runs scripts after it.

    Attributes:
        scripts: The scripts by attribute.
        pre_tick: Called before the tick of a node that has not completed; a SUCCESS or FAILURE
            that it returns replaces the tick; a running node is halted, so that a motion stops.
        post_tick: Called after the tick with its result; a SUCCESS or FAILURE replaces it.
    """

    def __init__(self, scripts: Mapping[str, ParsedScript]) -> None:
        self.scripts = scripts
        self._in_front = [(name, scripts[name]) for name in GUARDS if name in scripts]
        self.pre_tick: PreTick | None = None
        self.post_tick: PostTick | None = None

    def before(self, node: "Node") -> NodeStatus | None:
        """Return the status that replaces the tick, or None."""
        status = node._node_status
        if status is not IDLE and status is not RUNNING:
            return None
        for name, script in self._in_front:
            result, truth = GUARDS[name]
            if status is RUNNING and name != "_while":
                continue
            if is_true(script.evaluate(_environment(node))) is truth:
                if result is FAILURE:
                    node._because(f"{name}: {script.text}")
                if status is RUNNING:
                    node.halt()
                return result
        if self.pre_tick is None:
            return None
        state = _replaced(node, self.pre_tick(node))
        if state is not None and status is RUNNING:
            _abandon(node)
        return state

    def after(self, node: "Node", state: NodeStatus) -> NodeStatus:
        """Run the scripts that follow a completed tick, and return the final result."""
        if state is SUCCESS:
            self._run("_onSuccess", node)
            self._run("_post", node)
        elif state is FAILURE:
            self._run("_onFailure", node)
            self._run("_post", node)
        if self.post_tick is not None:
            return _replaced(node, self.post_tick(node, state)) or state
        return state

    def halted(self, node: "Node") -> None:
        """Run the script that follows a halt."""
        self._run("_onHalted", node)

    def _run(self, name: str, node: "Node") -> None:
        script: ParsedScript | None = self.scripts.get(name)
        if script is not None:
            script.evaluate(_environment(node))


def _environment(node: "Node") -> Environment:
    return Environment(node.scope, node.runtime.enums)


def _replaced(node: "Node", status: NodeStatus | None) -> NodeStatus | None:
    """Return the status that a hook sets, or None if it sets none."""
    if status is FAILURE:
        node._because("a hook replaced its status")
    return status if status is SUCCESS or status is FAILURE else None


def _abandon(node: "Node") -> None:
    """Halt a running node; its observers see only the status that replaces the tick's."""
    observers, node._node_observers = node._node_observers, ()
    try:
        node.halt()
    finally:
        node._node_observers = observers
    node._node_status = RUNNING
