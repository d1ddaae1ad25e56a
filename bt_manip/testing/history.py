"""Recorded status changes of the nodes of a tree."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bt_manip.bt import NodeStatus, Tree

_MARKS = {NodeStatus.RUNNING: ">", NodeStatus.SUCCESS: "+", NodeStatus.FAILURE: "x"}
_LAST_CHANGES = 12
_LONGEST_VALUE = 60


class StatusChange(NamedTuple):
    """One node's change of status."""

    tick: int  # from 1
    time: float  # [s] simulated
    node: Any
    status: NodeStatus
    message: str  # feedback message


@dataclass
class History:
    """Tree observer that records every change of status, except returns to idle."""

    tree: Tree
    tick: int = 0
    changes: list[StatusChange] = field(default_factory=list)

    def __call__(self, node: Any, old: NodeStatus, new: NodeStatus) -> None:
        """Record a change."""
        if new is not NodeStatus.IDLE:
            message = str(node.feedback_message)
            self.changes.append(StatusChange(self.tick, self.tree.clock(), node, new, message))

    def last(self, node: Any) -> StatusChange | None:
        """Return the last change of a node, or None when it was never ticked."""
        return next((change for change in reversed(self.changes) if change.node is node), None)


def explain(history: History) -> str:
    """Describe the node that decided, the status of all nodes, and the blackboard."""
    tree = history.tree
    lines = [f"after tick {history.tick}, at {tree.clock():.3f} s"]
    reason = tree.failure_reason()
    if reason:
        failed = [c for c in history.changes if c.status is NodeStatus.FAILURE]
        when = f" (tick {failed[-1].tick}, {failed[-1].time:.3f} s)" if failed else ""
        lines.append(f"failed: {reason}{when}")
    lines += ["tree:", *_tree_lines(history)]
    lines += ["last changes:", *_change_lines(history)]
    lines += ["blackboard:", *(_board_lines(tree) or ["  (empty)"])]
    return "\n".join(lines)


def _tree_lines(history: History) -> Iterator[str]:
    for node in history.tree.nodes:
        change = history.last(node)
        mark = "." if change is None else _MARKS.get(change.status, "-")
        kind = "" if node.registration == node.name else f" [{node.registration}]"
        said = f"  {change.message}" if change is not None and change.message else ""
        depth = _depth(node, history.tree)
        yield f"  {'  ' * depth}{mark} {node.name}{kind}{said}"


def _depth(node: Any, tree: Tree) -> int:
    behaviour = getattr(node, "behaviour", node)
    depth = 0
    while behaviour is not tree.root and behaviour.parent is not None:
        behaviour, depth = behaviour.parent, depth + 1
    return depth


def _change_lines(history: History) -> Iterator[str]:
    if len(history.changes) > _LAST_CHANGES:
        yield f"  ... {len(history.changes) - _LAST_CHANGES} before"
    for tick, time, node, status, message in history.changes[-_LAST_CHANGES:]:
        said = f"  {message}" if message else ""
        yield f"  tick {tick:<4} {time:.3f} s  {node.path or node.name} {status.name}{said}"


def _board_lines(tree: Tree) -> list[str]:
    lines = []
    for path, scope in tree.scopes.items():
        prefix = f"{path}: " if path else ""
        for key, entry in sorted(scope.entries.items()):
            written = entry.sequence > 0
            value = repr(entry.value) if written else "(never written)"
            if len(value) > _LONGEST_VALUE:
                value = value[: _LONGEST_VALUE - 3] + "..."
            lines.append(f"  {prefix}{key} = {value}")
    return lines
