"""Breakpoints and replaced statuses of nodes, which Groot2 sets while a tree runs."""

from collections import deque
from collections.abc import Callable, Container, Mapping
from functools import partial
from threading import Condition
from typing import Any, NamedTuple

from bt_manip.bt import Node, NodeStatus
from bt_manip.runner import Interventions
from bt_manip_groot.messages import RequestError, field_of

BREAKPOINT, REPLACE = 0, 1
"""Modes of a hook: wait until it is unlocked, or only replace the status."""

PRE, POST = 0, 1
"""Positions of a hook: before the node's tick, or after it."""

RECHECK = 0.05
"""Longest wall time in which a run that waits reacts to Ctrl-C [s]."""

Key = tuple[int, int]


class Hook(NamedTuple):
    """A breakpoint before or after the tick of a node, or a status that replaces the tick's.

    Attributes:
        desired_status: SUCCESS or FAILURE replaces the status of the tick; else the node is ticked.
        enabled: Whether it has an effect.
        mode: `BREAKPOINT` or `REPLACE`.
        once: Whether it is removed when it has had its effect.
        position: `PRE` or `POST`.
        uid: The node.
    """

    desired_status: str
    enabled: bool
    mode: int
    once: bool
    position: int
    uid: int


def key_of(data: Any) -> Key:
    """Return uid and position of a hook in a request.

    Raises:
        RequestError: If they are missing or invalid.
    """
    return field_of(data, "uid", int, 1 << 16), field_of(data, "position", int, 2)


def status_of(data: Any) -> str:
    """Return the desired status in a request; SKIPPED replaces nothing.

    Raises:
        RequestError: If there is none.
    """
    status = field_of(data, "desired_status", str)
    return status if status in ("SUCCESS", "FAILURE") else "SKIPPED"


class HookTable:
    """All hooks of a tree, changed by the thread of the publisher and obeyed by that of the run.

    Args:
        paused: Called by the run's thread when it waits at a breakpoint.
        stop: Returns whether the run has to end, and so must not wait.
    """

    def __init__(self, paused: Callable[[Node], None], stop: Callable[[], bool]) -> None:
        self._paused, self._stop = paused, stop
        self._condition = Condition()
        self._hooks: dict[Key, Hook] = {}
        self._waiting: Key | None = None  # of the breakpoint at which the run waits
        self._unlocked: Hook | None = None  # that breakpoint, when the run may go on
        self._suspended = False
        self._applied: set[int] = set()  # uids of the nodes that look for hooks
        self.reached: deque[int] = deque()
        """Uids of the nodes at whose breakpoints the run waited."""

    # Requests

    def insert(self, data: Any, uids: Container[int], nodes: Container[int]) -> None:
        """Insert or replace hooks.

        Args:
            data: A hook as a JSON object, or a list of them.
            uids: All nodes; others are ignored.
            nodes: The nodes that can have a hook.

        Raises:
            RequestError: If one of them is invalid; none is inserted then.
        """
        hooks: dict[Key, Hook] = {}
        for one in data if isinstance(data, list) else [data]:
            uid, position = key_of(one)
            hook = Hook(
                status_of(one),
                field_of(one, "enabled", bool),
                field_of(one, "mode", int, 2),
                field_of(one, "once", bool),
                position,
                uid,
            )
            if uid in uids:
                if uid not in nodes:
                    raise RequestError(f"node {uid} is of py_trees and cannot have a hook")
                hooks[uid, position] = hook
        with self._condition:
            self._hooks |= hooks
            self._condition.notify_all()

    def remove(self, key: Key) -> None:
        """Remove a hook.

        Raises:
            RequestError: If there is none.
        """
        with self._condition:
            self._find(key)
            del self._hooks[key]
            self._condition.notify_all()

    def clear(self) -> None:
        """Remove all hooks."""
        with self._condition:
            self._hooks.clear()
            self._applied.clear()
            self._condition.notify_all()

    def disable(self) -> None:
        """Disable all hooks; inserting one again enables it."""
        with self._condition:
            self._hooks = {key: one._replace(enabled=False) for key, one in self._hooks.items()}
            self._condition.notify_all()

    def unlock(self, data: Any) -> None:
        """Let a run go on that waits at a breakpoint.

        Args:
            data: ``uid``, ``position``, ``desired_status`` and ``remove_when_done``.

        Raises:
            RequestError: If there is no such hook, or if the data are invalid.
        """
        status, once = status_of(data), field_of(data, "remove_when_done", bool)
        key = key_of(data)
        with self._condition:
            hook = self._find(key)
            hook = hook._replace(desired_status=status, once=hook.once or once)
            self._hooks[key] = hook
            if self._waiting == key:
                self._unlocked = hook
                if hook.once:
                    del self._hooks[key]
            self._condition.notify_all()

    def dump(self) -> list[dict[str, Any]]:
        """Return all hooks as JSON objects, with sorted keys."""
        with self._condition:
            return [hook._asdict() for _, hook in sorted(self._hooks.items())]

    def suspend(self, suspended: bool) -> None:
        """Disable hooks while no client is connected: nobody could release them."""
        if suspended != self._suspended:
            with self._condition:
                self._suspended = suspended
                self._condition.notify_all()

    # The run

    def apply(self, nodes: Mapping[int, Node], interventions: Interventions) -> None:
        """Let the nodes of new hooks look for them, between two ticks."""
        with self._condition:
            new = {uid for uid, _ in self._hooks if uid in nodes} - self._applied
            self._applied |= new
        for uid in new:
            before, after = (partial(self._reach, (uid, position)) for position in (PRE, POST))
            interventions.set_tick_hooks(self, nodes[uid], before, after)

    # Internal

    def _find(self, key: Key) -> Hook:
        if key not in self._hooks:
            raise RequestError("Node ID not found")
        return self._hooks[key]

    def _reach(self, key: Key, node: Node, _: NodeStatus | None = None) -> NodeStatus | None:
        """Obey the hook of a node, if any; return the status that replaces the tick's."""
        with self._condition:
            hook = self._effective(key)
            if hook is not None and hook.mode == BREAKPOINT:
                hook = self._wait(key, node)
            elif hook is not None and hook.once:
                del self._hooks[key]
            return None if hook is None else NodeStatus[hook.desired_status]

    def _wait(self, key: Key, node: Node) -> Hook | None:
        """Wait at a breakpoint; return it when it was unlocked, None when the run has to go on."""
        self._waiting, self._unlocked = key, None
        self._paused(node)
        self.reached.append(node.uid)
        while self._unlocked is None and not self._stop():
            hook = self._effective(key)
            if hook is None or hook.mode != BREAKPOINT:
                break
            self._condition.wait(RECHECK)
        self._waiting = None
        return self._unlocked

    def _effective(self, key: Key) -> Hook | None:
        hook = self._hooks.get(key)
        return hook if hook is not None and hook.enabled and not self._suspended else None
