"""Breakpoints and replaced statuses of nodes, which Groot2 sets while a tree runs."""

from collections import deque
from collections.abc import Callable, Container, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from threading import Condition
from typing import Any

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


@dataclass(eq=False)
class Hook:
    """A breakpoint before or after the tick of a node, or a status that replaces the tick's.

    Attributes:
        uid: The node.
        position: `PRE` or `POST`.
        mode: `BREAKPOINT` or `REPLACE`.
        enabled: Whether it has an effect.
        once: Whether it is removed when it has had its effect.
        desired_status: SUCCESS or FAILURE replaces the status of the tick; else the node is ticked.
    """

    uid: int
    position: int
    mode: int
    enabled: bool
    once: bool
    desired_status: str


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
        self._unlocked: set[Key] = set()
        self._waiting: Key | None = None
        self._suspended = False
        self._changed = False
        self._applied: set[int] = set()
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
            key = key_of(one)
            hook = Hook(
                *key,
                mode=field_of(one, "mode", int, 2),
                enabled=field_of(one, "enabled", bool),
                once=field_of(one, "once", bool),
                desired_status=status_of(one),
            )
            if key[0] in uids:
                if key[0] not in nodes:
                    raise RequestError(f"node {key[0]} is of py_trees and cannot have a hook")
                hooks[key] = hook
        with self._condition:
            for key, hook in hooks.items():
                vars(self._hooks.setdefault(key, hook)).update(vars(hook))
            self._notify()

    def remove(self, key: Key) -> None:
        """Remove a hook.

        Raises:
            RequestError: If there is none.
        """
        with self._condition:
            self._find(key)
            del self._hooks[key]
            self._notify()

    def clear(self) -> None:
        """Remove all hooks."""
        with self._condition:
            self._hooks.clear()
            self._notify()

    def disable(self) -> None:
        """Disable all hooks; inserting one again enables it."""
        with self._condition:
            for hook in self._hooks.values():
                hook.enabled = False
            self._notify()

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
            hook.desired_status = status
            hook.once |= once
            if self._waiting == key:
                self._unlocked.add(key)
                if hook.once:  # at once, and not only when the run's thread wakes up
                    del self._hooks[key]
            self._notify()

    def dump(self) -> list[dict[str, Any]]:
        """Return all hooks as JSON objects, with sorted keys."""
        with self._condition:
            return [dict(sorted(asdict(hook).items())) for _, hook in sorted(self._hooks.items())]

    def suspend(self, suspended: bool) -> None:
        """Disable hooks while no client is connected: nobody could release them."""
        if suspended != self._suspended:
            with self._condition:
                self._suspended = suspended
                self._notify()

    # The run

    def apply(self, nodes: Mapping[int, Node], interventions: Interventions) -> None:
        """Set the hooks on their nodes, between two ticks.

        Args:
            nodes: The nodes by their uid.
            interventions: Those of the run, which emit the statuses that hooks set.
        """
        if not self._changed:
            return
        with self._condition:
            self._changed = False
            hooks = dict(self._hooks)
        uids = {uid for uid, _ in hooks}
        for uid in (uids | self._applied) & nodes.keys():
            before, after = hooks.get((uid, PRE)), hooks.get((uid, POST))
            interventions.set_tick_hooks(
                self,
                nodes[uid],
                partial(self._reach, before) if before else None,
                partial(self._reach, after) if after else None,
            )
        self._applied = uids

    # Internal

    def _find(self, key: Key) -> Hook:
        if key not in self._hooks:
            raise RequestError("Node ID not found")
        return self._hooks[key]

    def _notify(self) -> None:
        self._changed = True
        self._condition.notify_all()

    def _reach(self, hook: Hook, node: Node, state: NodeStatus | None = None) -> NodeStatus | None:
        """Obey a hook; return the status that replaces the tick's, if one does."""
        key = hook.uid, hook.position
        with self._condition:
            if not self._has_effect(hook):
                return None
            if hook.mode == BREAKPOINT:
                self._waiting = key
                self._paused(node)
                self.reached.append(hook.uid)
                while hook.mode == BREAKPOINT and self._has_effect(hook):
                    if key in self._unlocked or self._stop():
                        break
                    self._condition.wait(RECHECK)
                self._waiting = None
                if key in self._unlocked:
                    self._unlocked.remove(key)
                elif hook.mode == BREAKPOINT or not self._has_effect(hook):
                    return None
            if hook.once and self._hooks.get(key) is hook:
                del self._hooks[key]
                self._changed = True
            return NodeStatus[hook.desired_status]

    def _has_effect(self, hook: Hook) -> bool:
        found = self._hooks.get((hook.uid, hook.position))
        return found is hook and hook.enabled and not self._suspended
