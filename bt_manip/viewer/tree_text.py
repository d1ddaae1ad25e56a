"""A tree with its statuses as text."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.text import Text

MARKS = {
    "IDLE": ("·", "dim"),
    "RUNNING": ("▶", "bold yellow"),
    "SUCCESS": ("✓", "green"),
    "FAILURE": ("✗", "bold red"),
    "SKIPPED": ("-", "dim"),
}
"""Mark and style of each status."""

PLAIN_MARKS = {"▶": ">", "✓": "+", "✗": "x", "·": "."}
"""Marks for ASCII terminals."""


def tree_lines(root: Any, status_of: Any, *, ascii_only: bool = False) -> "Iterator[Text]":
    """Yield a line for each node, children below their parents.

    Args:
        root: The root behaviour.
        status_of: Returns the name of a node's status.
        ascii_only: Whether to use ASCII marks only.
    """
    from rich.text import Text

    # A stack instead of recursion: a tree may be deeper than Python's stack.
    stack = [(root, 0)]
    while stack:
        node, depth = stack.pop()
        status = status_of(node)
        mark, style = MARKS.get(status, ("?", "dim"))
        if ascii_only:
            mark = PLAIN_MARKS.get(mark, mark)
        line = Text("  " * depth, no_wrap=True, overflow="ellipsis")
        line.append(f"{mark} ", style=style)
        line.append(str(node.name), style=style if status != "SUCCESS" else "")
        kind = getattr(node, "registration", type(node).__name__)
        if kind != node.name:
            line.append(f" {kind}", style="dim")
        message = getattr(node, "feedback_message", "")
        if message and status != "IDLE":
            line.append(f"  {message}", style="dim")
        yield line
        stack.extend((child, depth + 1) for child in reversed(node.children))


def running_leaves(root: Any, status_of: Any) -> list[Any]:
    """Return the running leaves, in the order of the tree."""
    found = []
    stack = [root]
    while stack:
        node = stack.pop()
        if not node.children and status_of(node) == "RUNNING":
            found.append(node)
        stack.extend(reversed(node.children))
    return found
